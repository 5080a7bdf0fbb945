//! The classic syntax: VRML 1.0, VRML 2.0 (ISO/IEC 14772-1, 5.6 and annex A) and X3D (ISO/IEC 19776-2).
//!
//! Types of fields are not declared in a file, so they are told by what stands there: numbers, texts, flags or nodes.

use super::FORMAT;
use super::external::{self, Source};
use super::first;
use super::node::{Node, Value, number};
use super::prototype::{self, Body};
use super::reading::Reading;
use crate::LoadError;
use crate::text::{line_of, quoted};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::rc::Rc;

/// A word of the text.
#[derive(Clone, Debug, PartialEq)]
enum Token<'a> {
    Word(&'a str),
    Text(String),
    /// One of `{ } [ ]`.
    Bracket(u8),
}

/// Words of a text, one after the other.
#[derive(Clone)]
struct Words<'a> {
    text: &'a str,
    place: usize,
}

impl<'a> Words<'a> {
    fn rest(&self) -> &'a [u8] {
        self.text.as_bytes().get(self.place..).unwrap_or_default()
    }

    fn skip(&mut self, count: usize) {
        self.place = self.place.saturating_add(count);
    }

    fn next(&mut self) -> Option<Token<'a>> {
        loop {
            let rest = self.rest();
            let first = *rest.first()?;
            if first.is_ascii_whitespace() || first == b',' {
                self.skip(1);
            } else if first == b'#' {
                let end = rest.iter().position(|&b| b == b'\n' || b == b'\r');
                self.skip(end.unwrap_or(rest.len()));
            } else if matches!(first, b'{' | b'}' | b'[' | b']') {
                self.skip(1);
                return Some(Token::Bracket(first));
            } else if first == b'"' {
                self.skip(1);
                return Some(Token::Text(self.quoted()));
            } else {
                let ends = |&b: &u8| b.is_ascii_whitespace() || b",#{}[]\"".contains(&b);
                let length = rest.iter().position(ends).unwrap_or(rest.len());
                let start = self.place;
                self.skip(length);
                // Whatever ends a word is of one byte, so that it is cut between letters.
                return Some(Token::Word(self.text.get(start..self.place).unwrap_or_default()));
            }
        }
    }

    /// The rest of a text in quotes.
    fn quoted(&mut self) -> String {
        let (mut out, mut escaped) = (Vec::new(), false);
        let mut length = 0_usize;
        for &byte in self.rest() {
            length = length.saturating_add(1);
            match byte {
                b'\\' if !escaped => escaped = true,
                b'"' if !escaped => break,
                _ => {
                    out.push(byte);
                    escaped = false;
                }
            }
        }
        self.skip(length);
        String::from_utf8_lossy(&out).into_owned()
    }

    fn peek(&self) -> Option<Token<'a>> {
        self.clone().next()
    }
}

/// Words that declare a field of a script or prototype.
const DECLARATIONS: [&str; 8] = [
    "eventIn",
    "eventOut",
    "exposedField",
    "field",
    "inputOnly",
    "outputOnly",
    "inputOutput",
    "initializeOnly",
];

/// Words that declare an event, which has no value.
const EVENTS: [&str; 4] = ["eventIn", "eventOut", "inputOnly", "outputOnly"];

/// Reads a text: its outermost nodes. One of VRML 1.0 (`is_first`) has children among the fields of a node, and no prototypes.
pub(super) fn read(text: &str, is_first: bool, reading: &mut Reading<'_>) -> Result<Vec<usize>, LoadError> {
    let mut work = 0;
    let mut parser = Parser::new(text, reading, (0, &mut work));
    parser.is_first = is_first;
    let mut roots = Vec::new();
    loop {
        match parser.words.next() {
            None => return Ok(roots),
            Some(Token::Word(word)) => {
                if is_first || !parser.statement(word)? {
                    roots.extend(parser.node(word)?);
                }
            }
            // A bracket too many ends nothing.
            Some(Token::Bracket(b'}' | b']')) => {}
            Some(other) => return Err(parser.unexpected(Some(other), "a node")),
        }
    }
}

/// Reads the nodes of a prototype of a text, by its name or the first of all, for a use of it.
pub(super) fn instance_of(
    text: &str,
    name: &str,
    own: Node,
    reading: &mut Reading<'_>,
    uses: (usize, &mut usize),
) -> Result<Option<usize>, LoadError> {
    let mut parser = Parser::new(text, reading, uses);
    loop {
        match parser.words.next() {
            None => {
                external::missing(parser.reading, name);
                return Ok(None);
            }
            Some(Token::Word(word @ ("PROTO" | "EXTERNPROTO"))) => {
                let found = parser.words.peek();
                parser.statement(word)?;
                let Some(Token::Word(found)) = found else { continue };
                if name.is_empty() || name == found {
                    let Some(prototype) = parser.prototypes.get(found).cloned() else { continue };
                    return parser.instance(&prototype, own);
                }
            }
            Some(_) => {}
        }
    }
}

/// A prototype whose nodes begin at this place.
type Prototype = prototype::Prototype<usize>;

struct Parser<'a, 'r, 'n> {
    words: Words<'a>,
    is_first: bool,
    reading: &'r mut Reading<'n>,
    prototypes: BTreeMap<&'a str, Rc<Prototype>>,
    /// Fields of the prototypes' uses that are read.
    scopes: Vec<Rc<Node>>,
    /// Uses of prototypes of other files around this one.
    around: usize,
    /// Bytes of prototypes that have been read again.
    work: &'r mut usize,
}

impl<'a, 'r, 'n> Parser<'a, 'r, 'n> {
    fn new(text: &'a str, reading: &'r mut Reading<'n>, (around, work): (usize, &'r mut usize)) -> Self {
        let words = Words { text, place: 0 };
        let (prototypes, scopes) = (BTreeMap::new(), Vec::new());
        Self { words, is_first: false, reading, prototypes, scopes, around, work }
    }

    fn error(&self, message: impl std::fmt::Display) -> LoadError {
        let line = line_of(self.words.text.as_bytes(), self.words.rest());
        LoadError::malformed(FORMAT, format!("line {line}: {message}"))
    }

    fn unexpected(&self, token: Option<Token<'_>>, wanted: &str) -> LoadError {
        match token {
            None => self.error(format!("the file ends where {wanted} should be")),
            Some(Token::Word(word)) => {
                self.error(format!("{} where {wanted} should be", quoted(word.as_bytes())))
            }
            Some(Token::Text(_)) => self.error(format!("a text where {wanted} should be")),
            Some(Token::Bracket(b)) => self.error(format!("{} where {wanted} should be", char::from(b))),
        }
    }

    fn word(&mut self, wanted: &str) -> Result<&'a str, LoadError> {
        match self.words.next() {
            Some(Token::Word(word)) => Ok(word),
            other => Err(self.unexpected(other, wanted)),
        }
    }

    /// Skips a statement that is no node; false for the first word of a node.
    fn statement(&mut self, word: &str) -> Result<bool, LoadError> {
        match word {
            "PROTO" => {
                let name = self.word("the name of a prototype")?;
                let defaults = self.interface()?;
                let body = self.words.place;
                self.skip_brackets(b'{')?;
                self.prototypes.insert(name, Rc::new(Prototype { defaults, body: Body::Here(body) }));
            }
            "EXTERNPROTO" => {
                let name = self.word("the name of a prototype")?;
                self.skip_brackets(b'[')?;
                let mut file = Node::default();
                self.value("url", &mut file)?;
                let body = Body::There(Source { urls: file.strings("url") });
                self.prototypes.insert(name, Rc::new(Prototype { defaults: Node::default(), body }));
            }
            // ROUTE a.b TO c.d, META "name" "content", UNIT category name factor, IMPORT a.b AS c.
            "ROUTE" | "UNIT" => self.skip_words(3),
            "META" => self.skip_words(2),
            "PROFILE" | "COMPONENT" => self.skip_words(1),
            "IMPORT" | "EXPORT" => {
                self.skip_words(1);
                if self.words.peek() == Some(Token::Word("AS")) {
                    self.skip_words(2);
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn skip_words(&mut self, count: u32) {
        for _ in 0..count {
            self.words.next();
        }
    }

    /// Skips what is in brackets, with brackets within.
    fn skip_brackets(&mut self, open: u8) -> Result<(), LoadError> {
        match self.words.next() {
            Some(Token::Bracket(bracket)) if bracket == open => {}
            other => return Err(self.unexpected(other, "a bracket")),
        }
        let mut depth = 1_u64;
        while depth > 0 {
            match self.words.next() {
                Some(Token::Bracket(b'{' | b'[')) => depth = depth.saturating_add(1),
                Some(Token::Bracket(_)) => depth = depth.saturating_sub(1),
                Some(_) => {}
                None => return Err(self.unexpected(None, "a closing bracket")),
            }
        }
        Ok(())
    }

    /// Reads the fields of a prototype with their default values.
    fn interface(&mut self) -> Result<Node, LoadError> {
        match self.words.next() {
            Some(Token::Bracket(b'[')) => {}
            other => return Err(self.unexpected(other, "[ of a prototype")),
        }
        let mut defaults = Node::default();
        loop {
            match self.words.next() {
                Some(Token::Bracket(b']')) => return Ok(defaults),
                Some(Token::Word(word)) => {
                    self.word("the type of a field")?;
                    let name = self.word("the name of a field")?;
                    if !EVENTS.contains(&word) {
                        self.value(name, &mut defaults)?;
                    }
                }
                other => return Err(self.unexpected(other, "a field of a prototype")),
            }
        }
    }

    /// Reads the nodes of a prototype for a use of it: the first of them stands for it.
    fn instance(&mut self, prototype: &Prototype, own: Node) -> Result<Option<usize>, LoadError> {
        let begun = prototype.begin(own, self.reading, &mut self.scopes, (self.around, &mut *self.work))?;
        let body = match begun {
            ControlFlow::Continue(body) => body,
            ControlFlow::Break(node) => return Ok(node),
        };
        let after = self.words.place;
        self.words.place = body;
        self.words.next();
        let mut found = None;
        while found.is_none() {
            match self.words.next() {
                Some(Token::Word(word)) => {
                    if !self.statement(word)? {
                        found = self.node(word)?;
                    }
                }
                None | Some(Token::Bracket(b'}')) => break,
                other => return Err(self.unexpected(other, "a node")),
            }
        }
        prototype::end(self.reading, &mut self.scopes);
        *self.work = self.work.saturating_add(self.words.place.saturating_sub(body));
        self.words.place = after;
        Ok(found)
    }

    /// Reads a node whose first word is read; none for NULL and names that are not known.
    fn node(&mut self, word: &str) -> Result<Option<usize>, LoadError> {
        match word {
            "NULL" => return Ok(None),
            "USE" => {
                let name = self.word("the name of a node")?;
                return Ok(self.reading.used(name));
            }
            _ => {}
        }
        let (mut kind, mut name) = (word, None);
        if word == "DEF" {
            name = Some(self.word("the name of a node")?.to_owned());
            kind = self.word("a node")?;
        }
        match self.words.next() {
            Some(Token::Bracket(b'{')) => {}
            other => return Err(self.unexpected(other, "{ of a node")),
        }
        self.reading.enter()?;
        let mut node = Node { kind: kind.to_owned(), ..Node::default() };
        loop {
            match self.words.next() {
                Some(Token::Bracket(b'}')) => break,
                Some(Token::Word(word)) if self.is_first => self.first_field(word, &mut node)?,
                Some(Token::Word(word)) => self.field(word, &mut node)?,
                // Nodes end with the file.
                None => {
                    self.reading.warnings.add(|| format!("{FORMAT}: the file ends within a node"));
                    break;
                }
                other => return Err(self.unexpected(other, "a field")),
            }
        }
        if self.is_first {
            first::renamed(&mut node);
        }
        let Some(prototype) = self.prototypes.get(kind).cloned() else {
            return self.reading.leave(node, name).map(Some);
        };
        let found = self.instance(&prototype, node)?;
        self.reading.leave_use(found, name);
        Ok(found)
    }

    /// Reads a field or child of a node of VRML 1.0, whose first word is read.
    fn first_field(&mut self, word: &'a str, node: &mut Node) -> Result<(), LoadError> {
        let next = self.words.peek();
        if matches!(word, "DEF" | "USE") || next == Some(Token::Bracket(b'{')) {
            node.children.extend(self.node(word)?.map(|child| (String::new(), child)));
            return Ok(());
        }
        let is_list = next == Some(Token::Bracket(b'['));
        if is_list && matches!(word, "fields" | "isA") {
            // Types of the fields of nodes that are no part of the language.
            return self.skip_brackets(b'[');
        }
        if is_list {
            self.words.next();
        }
        let (mut numbers, mut strings) = (Vec::new(), Vec::new());
        let mut flag = None;
        loop {
            match self.words.next() {
                Some(Token::Bracket(b']')) if is_list => break,
                None if is_list => break,
                Some(Token::Text(text)) => strings.push(text),
                Some(Token::Word("TRUE")) => flag = Some(true),
                Some(Token::Word("FALSE")) => flag = Some(false),
                // Several names at once: (SIDES | TOP).
                Some(Token::Word(word)) if word.starts_with('(') => {
                    strings.push(word.to_owned());
                    let mut last = word;
                    while !last.ends_with(')') {
                        last = self.word("a closing parenthesis")?;
                        strings.push(last.to_owned());
                    }
                }
                Some(Token::Word(word)) => match number(word) {
                    Some(number) => {
                        numbers.push(number);
                        self.numbers(&mut numbers);
                    }
                    None => strings.push(word.to_owned()),
                },
                other => return Err(self.unexpected(other, "a value")),
            }
            if !is_list {
                break;
            }
        }
        // An empty list is a value: a material without diffuse colours glows.
        let value = match flag {
            Some(flag) => Value::Flag(flag),
            None if strings.is_empty() => Value::Numbers(numbers),
            None => Value::Strings(strings),
        };
        node.fields.insert(word.to_owned(), value);
        Ok(())
    }

    /// Reads a field, whose name is read.
    fn field(&mut self, word: &'a str, node: &mut Node) -> Result<(), LoadError> {
        if self.statement(word)? {
            return Ok(());
        }
        let mut name = word;
        if DECLARATIONS.contains(&word) {
            self.word("the type of a field")?;
            name = self.word("the name of a field")?;
            if EVENTS.contains(&word) {
                if self.words.peek() == Some(Token::Word("IS")) {
                    self.skip_words(2);
                }
                return Ok(());
            }
        }
        self.value(name, node)
    }

    fn value(&mut self, name: &str, node: &mut Node) -> Result<(), LoadError> {
        match self.words.next() {
            Some(Token::Bracket(b'[')) => {
                let (mut numbers, mut strings) = (Vec::new(), Vec::new());
                loop {
                    match self.words.next() {
                        Some(Token::Bracket(b']')) | None => break,
                        Some(Token::Text(text)) => strings.push(text),
                        Some(Token::Word(word)) => match number(word) {
                            Some(number) => {
                                numbers.push(number);
                                self.numbers(&mut numbers);
                            }
                            None if matches!(word, "TRUE" | "FALSE" | "true" | "false") => {}
                            // Routes and prototypes may stand between nodes.
                            None if self.statement(word)? => {}
                            None => {
                                if let Some(child) = self.node(word)? {
                                    node.children.push((name.to_owned(), child));
                                }
                            }
                        },
                        other => return Err(self.unexpected(other, "a value")),
                    }
                }
                if !numbers.is_empty() {
                    node.fields.insert(name.to_owned(), Value::Numbers(numbers));
                } else if !strings.is_empty() {
                    node.fields.insert(name.to_owned(), Value::Strings(strings));
                }
            }
            Some(Token::Text(text)) => {
                node.fields.insert(name.to_owned(), Value::Strings(vec![text]));
            }
            Some(Token::Word("TRUE" | "true")) => {
                node.fields.insert(name.to_owned(), Value::Flag(true));
            }
            Some(Token::Word("FALSE" | "false")) => {
                node.fields.insert(name.to_owned(), Value::Flag(false));
            }
            // The value of a prototype's field.
            Some(Token::Word("IS")) => {
                let field = self.word("the name of a field")?;
                let Some(scope) = self.scopes.last().cloned() else { return Ok(()) };
                self.reading.connect(&scope, field, node, name)?;
            }
            Some(Token::Word(word)) => match number(word) {
                Some(number) => {
                    let mut numbers = vec![number];
                    self.numbers(&mut numbers);
                    node.fields.insert(name.to_owned(), Value::Numbers(numbers));
                }
                None => {
                    if let Some(child) = self.node(word)? {
                        node.children.push((name.to_owned(), child));
                    }
                }
            },
            other => return Err(self.unexpected(other, "a value")),
        }
        Ok(())
    }

    /// Adds the numbers that follow.
    fn numbers(&mut self, numbers: &mut Vec<f64>) {
        loop {
            let before = self.words.place;
            let found = match self.words.next() {
                Some(Token::Word(word)) => number(word),
                _ => None,
            };
            let Some(number) = found else {
                self.words.place = before;
                return;
            };
            numbers.push(number);
        }
    }
}

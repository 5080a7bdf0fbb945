//! Keys of the window, as `--help` and the help over the picture list them.

/// Keys, and what they do.
pub const KEYS: [[&str; 2]; 14] = [
    ["drag", "turn"],
    ["right drag, Shift drag", "move"],
    ["wheel", "come closer"],
    ["click", "print what is there"],
    ["drop a file", "show it"],
    ["M, Shift M", "next, last shading model"],
    ["Q", "next tier"],
    ["S", "next number of samples (1, 4, 8, 16)"],
    ["G", "floor"],
    ["E", "environment: studio, none, seen"],
    ["Space", "play the animation"],
    ["R", "back to where it began"],
    ["H, F1", "this help, and how the picture was drawn"],
    ["Escape", "end"],
];

// overcoat-step: STEP and IGES files as GLB on standard output, by OpenCASCADE.
//
// A converter as overcoat runs them: one file in, GLB out, remarks on standard error (lines that begin with "warning:"),
// exit code 0 if there is a model. Names, colours (of faces before those of shapes), assemblies and instances are kept:
// a part is one mesh, however often it is placed. Units become metres, +Z up becomes +Y up, as glTF has them.

#include <BRepAdaptor_Curve.hxx>
#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GCPnts_TangentialDeflection.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Quantity_ColorRGBA.hxx>
#include <RWMesh_FaceIterator.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDF_Tool.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopoDS.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XCAFPrs_DocumentExplorer.hxx>
#include <gp_Trsf.hxx>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>

namespace {

// Shapes that lie in each other, at most: files can say that a part contains itself.
constexpr int kMostDepth = 256;
// Nodes, at most: parts that contain each other twice, forty deep, are more than there is memory for.
constexpr size_t kMostNodes = 1u << 20;

struct Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Options {
    std::string input;
    // Longer side of the picture: surfaces are off by half a pixel where the whole model fills it.
    double pixels = 1024;
    // Millimetres that surfaces may be off, in place of what the picture needs; 0 if it is not given.
    double deflection = 0;
    // Degrees between neighbouring facets of a curved surface.
    double angle = 20;
};

const char* const kUsage = "usage: overcoat-step [--pixels N] [--deflection MM] [--angle DEGREES] FILE > OUT.glb";

double number(const char* text, double least, double most) {
    char* end = nullptr;
    const double value = std::strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= least && value <= most)) {
        throw Failure(std::string("'") + text + "' is not in range; " + kUsage);
    }
    return value;
}

Options parse(int argc, char** argv) {
    Options options;
    for (int k = 1; k < argc; ++k) {
        const std::string argument = argv[k];
        const bool has_value = k + 1 < argc;
        if (argument == "--pixels" && has_value) {
            options.pixels = number(argv[++k], 1, 1e6);
        } else if (argument == "--deflection" && has_value) {
            options.deflection = number(argv[++k], 1e-6, 1e6);
        } else if (argument == "--angle" && has_value) {
            options.angle = number(argv[++k], 1, 90);
        } else if (argument.rfind("--", 0) == 0 || !options.input.empty()) {
            throw Failure(kUsage);
        } else {
            options.input = argument;
        }
    }
    if (options.input.empty()) {
        throw Failure(kUsage);
    }
    return options;
}

enum class Kind { Step, Iges };

struct Sniffed {
    Kind kind;
    bool is_whole;
    // Documents beside it have shapes of its assembly.
    bool refers_elsewhere;
};

bool mentions(std::ifstream& file, const std::string& word) {
    file.clear();
    file.seekg(0);
    for (std::string line; std::getline(file, line);) {
        if (line.find(word) != std::string::npos) {
            return true;
        }
    }
    return false;
}

// The format by a file's first lines, and whether its end is there.
Sniffed sniff(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw Failure("the file cannot be read");
    }
    std::string head(4096, '\0');
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<size_t>(file.gcount()));
    file.clear();
    file.seekg(0, std::ios::end);
    const std::streamoff size = file.tellg();
    file.seekg(std::max<std::streamoff>(0, size - 4096));
    const std::string tail((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (head.find("ISO-10303-21") != std::string::npos) {
        return {Kind::Step, tail.find("END-ISO-10303-21") != std::string::npos, mentions(file, "DOCUMENT_FILE")};
    }
    // Lines of 80 characters, of which the 73rd names the section: the first is S, the last T.
    const size_t line = head.find_first_of("\r\n");
    if (line != std::string::npos && line >= 73 && (head[72] == 'S' || head[72] == 'C')) {
        size_t end = tail.find_last_not_of("\r\n \t\x1a");
        end = end == std::string::npos ? 0 : end;
        const size_t begin = tail.find_last_of("\r\n", end);
        const std::string last = begin == std::string::npos ? tail : tail.substr(begin + 1);
        return {Kind::Iges, last.size() > 72 && last[72] == 'T', false};
    }
    throw Failure("the file is neither STEP nor IGES");
}

template <typename Reader>
void transfer(Reader& reader, const Options& options, Handle(TDocStd_Document) & document) {
    reader.SetColorMode(true);
    reader.SetNameMode(true);
    reader.SetLayerMode(false);
    if (reader.ReadFile(options.input.c_str()) != IFSelect_RetDone) {
        throw Failure("the file is damaged: OpenCASCADE cannot read it");
    }
    if (!reader.Transfer(document)) {
        throw Failure("there is no shape in the file that OpenCASCADE can read");
    }
}

struct Colour {
    float rgba[4];
    bool operator<(const Colour& other) const {
        return std::lexicographical_compare(rgba, rgba + 4, other.rgba, other.rgba + 4);
    }
};

// Linear, warm light grey: that of overcoat for models without materials.
constexpr Colour kClay = {{0.479f, 0.434f, 0.392f, 1.0f}};

// The part of a mesh that has one colour.
struct Group {
    std::vector<float> positions;
    std::vector<float> normals;
    std::vector<uint32_t> indices;
    bool has_normals = true;
    bool is_lines = false;
};

// GLB: JSON and the bytes that it refers to.
class Glb {
public:
    // Index of the material of a colour.
    int material(const Colour& colour) {
        const auto found = materials_.find(colour);
        if (found != materials_.end()) {
            return found->second;
        }
        const int index = static_cast<int>(materials_.size());
        materials_.emplace(colour, index);
        std::ostringstream json;
        const float* c = colour.rgba;
        json << std::setprecision(9) << "{\"doubleSided\":true,\"pbrMetallicRoughness\":{\"baseColorFactor\":[" << c[0] << ','
             << c[1] << ',' << c[2] << ',' << c[3] << "],\"metallicFactor\":0,\"roughnessFactor\":0.6}";
        json << (c[3] < 1 ? ",\"alphaMode\":\"BLEND\"}" : "}");
        add(material_json_, json.str());
        return index;
    }

    // Adds a primitive and returns its JSON.
    std::string primitive(const Group& group, int material) {
        std::ostringstream json;
        json << "{\"mode\":" << (group.is_lines ? 1 : 4) << ",\"material\":" << material << ",\"attributes\":{\"POSITION\":";
        json << vectors(group.positions, true);
        if (group.has_normals && !group.is_lines) {
            json << ",\"NORMAL\":" << vectors(group.normals, false);
        }
        json << '}';
        json << ",\"indices\":" << accessor(group.indices.data(), group.indices.size() * 4, 34963, 5125, group.indices.size(), "SCALAR", "");
        json << '}';
        return json.str();
    }

    int mesh(const std::string& primitives, const std::string& name) {
        add(mesh_json_, "{\"name\":" + quoted(name) + ",\"primitives\":[" + primitives + "]}");
        return mesh_count_++;
    }

    // Adds a node; its children are those that name it.
    int node(const std::string& name, const std::string& matrix, int mesh) {
        if (nodes_.size() >= kMostNodes) {
            throw Failure("there are more than " + std::to_string(kMostNodes) + " parts in the assembly");
        }
        nodes_.push_back({name, matrix, mesh, {}});
        return static_cast<int>(nodes_.size()) - 1;
    }

    void child(int parent, int child) { nodes_[static_cast<size_t>(parent)].children.push_back(child); }

    // All of it, to a descriptor. The first node is the root.
    void write(int descriptor) {
        std::ostringstream json;
        json << "{\"asset\":{\"version\":\"2.0\",\"generator\":\"overcoat-step\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[";
        for (size_t k = 0; k < nodes_.size(); ++k) {
            const Node& node = nodes_[k];
            json << (k ? ",{" : "{") << "\"name\":" << quoted(node.name);
            if (!node.matrix.empty()) {
                json << ",\"matrix\":" << node.matrix;
            }
            if (node.mesh >= 0) {
                json << ",\"mesh\":" << node.mesh;
            }
            for (size_t c = 0; c < node.children.size(); ++c) {
                json << (c ? "," : ",\"children\":[") << node.children[c];
            }
            json << (node.children.empty() ? "}" : "]}");
        }
        json << "],\"meshes\":[" << mesh_json_ << "],\"materials\":[" << material_json_ << "],\"accessors\":[" << accessor_json_
             << "],\"bufferViews\":[" << view_json_ << "],\"buffers\":[{\"byteLength\":" << bytes_.size() << "}]}";
        std::string text = json.str();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const uint64_t all = 12 + 8 + text.size() + 8 + bytes_.size();
        if (all > std::numeric_limits<uint32_t>::max()) {
            throw Failure("the model is larger than the 4 GiB of a GLB");
        }
        std::string head("glTF");
        for (const uint64_t word : {uint64_t{2}, all, uint64_t{text.size()}, uint64_t{0x4e4f534a}}) {
            put(head, static_cast<uint32_t>(word));
        }
        std::string chunk;
        put(chunk, static_cast<uint32_t>(bytes_.size()));
        put(chunk, 0x004e4942);
        send(descriptor, head.data(), head.size());
        send(descriptor, text.data(), text.size());
        send(descriptor, chunk.data(), chunk.size());
        send(descriptor, bytes_.data(), bytes_.size());
    }

    bool is_empty() const { return mesh_count_ == 0; }

private:
    struct Node {
        std::string name;
        std::string matrix;
        int mesh;
        std::vector<int> children;
    };

    static void add(std::string& list, const std::string& element) {
        list += list.empty() ? element : "," + element;
    }

    static void put(std::string& to, uint32_t word) {
        for (int k = 0; k < 4; ++k) {
            to.push_back(static_cast<char>(word >> (8 * k) & 255));
        }
    }

    static void send(int descriptor, const char* bytes, size_t count) {
        while (count > 0) {
            const ssize_t sent = ::write(descriptor, bytes, count);
            if (sent <= 0) {
                throw Failure("standard output cannot be written");
            }
            bytes += sent;
            count -= static_cast<size_t>(sent);
        }
    }

    static std::string quoted(const std::string& text) {
        std::ostringstream out;
        out << '"';
        for (const unsigned char c : text) {
            if (c == '"' || c == '\\') {
                out << '\\' << c;
            } else if (c < 32 || c == 127) {
                out << ' ';
            } else {
                out << c;
            }
        }
        out << '"';
        return out.str();
    }

    int vectors(const std::vector<float>& values, bool has_bounds) {
        std::ostringstream bounds;
        if (has_bounds) {
            float least[3], most[3];
            std::fill(least, least + 3, std::numeric_limits<float>::max());
            std::fill(most, most + 3, std::numeric_limits<float>::lowest());
            for (size_t k = 0; k < values.size(); ++k) {
                least[k % 3] = std::min(least[k % 3], values[k]);
                most[k % 3] = std::max(most[k % 3], values[k]);
            }
            bounds << std::setprecision(9) << ",\"min\":[" << least[0] << ',' << least[1] << ',' << least[2] << "],\"max\":["
                   << most[0] << ',' << most[1] << ',' << most[2] << ']';
        }
        return accessor(values.data(), values.size() * 4, 34962, 5126, values.size() / 3, "VEC3", bounds.str());
    }

    int accessor(const void* data, size_t bytes, int target, int type, size_t count, const char* shape, const std::string& more) {
        const char* begin = static_cast<const char*>(data);
        std::ostringstream view;
        view << "{\"buffer\":0,\"byteOffset\":" << bytes_.size() << ",\"byteLength\":" << bytes << ",\"target\":" << target << '}';
        bytes_.insert(bytes_.end(), begin, begin + bytes);
        add(view_json_, view.str());
        std::ostringstream json;
        json << "{\"bufferView\":" << accessor_count_ << ",\"componentType\":" << type << ",\"count\":" << count << ",\"type\":\""
             << shape << '"' << more << '}';
        add(accessor_json_, json.str());
        return accessor_count_++;
    }

    std::map<Colour, int> materials_;
    std::string material_json_, mesh_json_, accessor_json_, view_json_;
    std::vector<Node> nodes_;
    std::vector<char> bytes_;
    int accessor_count_ = 0, mesh_count_ = 0;
};

std::string name_of(const TDF_Label& label) {
    Handle(TDataStd_Name) name;
    if (label.IsNull() || !label.FindAttribute(TDataStd_Name::GetID(), name)) {
        return {};
    }
    return TCollection_AsciiString(name->Get()).ToCString();
}

// The sixteen numbers of a transformation, by columns; empty for none.
std::string matrix_of(const TopLoc_Location& location) {
    if (location.IsIdentity()) {
        return {};
    }
    const gp_Trsf& trsf = location.Transformation();
    std::ostringstream json;
    json << std::setprecision(9) << '[';
    for (int column = 1; column <= 4; ++column) {
        for (int row = 1; row <= 3; ++row) {
            json << trsf.Value(row, column) << ',';
        }
        json << (column == 4 ? "1]" : "0,");
    }
    return json.str();
}

class Converter {
public:
    Converter(const Options& options, bool refers_elsewhere) : options_(options), refers_elsewhere_(refers_elsewhere) {}

    // Meshes all shapes of a document and adds them to the GLB.
    void add(const Handle(TDocStd_Document) & document) {
        const Handle(XCAFDoc_ShapeTool) tool = XCAFDoc_DocumentTool::ShapeTool(document->Main());
        TDF_LabelSequence roots;
        tool->GetFreeShapes(roots);
        Bnd_Box box;
        for (const TDF_Label& root : roots) {
            const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(root);
            if (!shape.IsNull()) {
                BRepBndLib::Add(shape, box, false);
            }
        }
        if (box.IsVoid()) {
            throw Failure(refers_elsewhere_ ? "its shapes are in other files, which a converter does not see" : "there is no shape in the file");
        }
        deflection_ = options_.deflection;
        if (deflection_ == 0) {
            const double size = box.IsOpen() ? 1000 : std::sqrt(box.SquareExtent());
            deflection_ = std::max(size / options_.pixels / 2, 1e-7);
        }
        // Millimetres and +Z up become metres and +Y up; what faced -Y faces +Z.
        const int root = glb.node("", "[0.001,0,0,0, 0,0,-0.001,0, 0,0.001,0,0, 0,0,0,1]", -1);
        std::vector<int> parents = {root};
        XCAFPrs_DocumentExplorer explorer(document, XCAFPrs_DocumentExplorerFlags_None);
        for (; explorer.More(); explorer.Next()) {
            const XCAFPrs_DocumentNode& node = explorer.Current();
            const size_t depth = static_cast<size_t>(explorer.CurrentDepth());
            if (depth > kMostDepth) {
                throw Failure("parts lie in each other more than " + std::to_string(kMostDepth) + " deep");
            }
            std::string name = name_of(node.Label);
            // Exporters call a placement NAUO1 or =>[0:1:1:2]; the part has the name that people gave.
            if (name.empty() || name.rfind("NAUO", 0) == 0 || name.rfind("=>", 0) == 0) {
                name = name_of(node.RefLabel);
            }
            const int mesh = node.IsAssembly ? -1 : mesh_of(node.RefLabel, node.Style, name_of(node.RefLabel));
            const int added = glb.node(name, matrix_of(node.LocalTrsf), mesh);
            parents.resize(std::min(parents.size(), depth + 1));
            glb.child(parents.back(), added);
            parents.push_back(added);
        }
        if (glb.is_empty()) {
            throw Failure("there is no surface in the file that could be drawn");
        }
        if (faces_without_ > 0) {
            std::cerr << "warning: " << faces_without_ << " of " << faces_ << " surfaces are left out: they cannot be made triangles\n";
        }
    }

    Glb glb;

private:
    // The mesh of a part in a colour that it inherits; -1 if there is nothing in it. Each is made once.
    int mesh_of(const TDF_Label& label, const XCAFPrs_Style& style, const std::string& name) {
        TCollection_AsciiString key;
        TDF_Tool::Entry(label, key);
        std::ostringstream full;
        full << key.ToCString();
        if (style.IsSetColorSurf()) {
            const NCollection_Vec4<float> c = style.GetColorSurfRGBA();
            full << ':' << c.r() << ',' << c.g() << ',' << c.b() << ',' << c.a();
        }
        const auto found = meshes_.find(full.str());
        if (found != meshes_.end()) {
            return found->second;
        }
        const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
        int mesh = -1;
        if (!shape.IsNull()) {
            BRepMesh_IncrementalMesh(shape, deflection_, false, options_.angle * M_PI / 180, false);
            std::map<Colour, Group> groups;
            surfaces(label, style, groups);
            std::string primitives;
            for (const auto& [colour, group] : groups) {
                add_to(primitives, glb.primitive(group, glb.material(colour)));
            }
            Group lines;
            lines.is_lines = true;
            curves(shape, lines);
            if (!lines.indices.empty()) {
                add_to(primitives, glb.primitive(lines, glb.material(Colour{{0.02f, 0.02f, 0.02f, 1.0f}})));
            }
            mesh = primitives.empty() ? -1 : glb.mesh(primitives, name);
        }
        meshes_.emplace(full.str(), mesh);
        return mesh;
    }

    static void add_to(std::string& list, const std::string& element) {
        list += list.empty() ? element : "," + element;
    }

    // The triangles of a part by colour: that of a face, else that of its shape, else the one that is inherited, else clay.
    void surfaces(const TDF_Label& label, const XCAFPrs_Style& style, std::map<Colour, Group>& groups) {
        for (TopExp_Explorer faces(XCAFDoc_ShapeTool::GetShape(label), TopAbs_FACE); faces.More(); faces.Next()) {
            TopLoc_Location location;
            ++faces_;
            const Handle(Poly_Triangulation) made = BRep_Tool::Triangulation(TopoDS::Face(faces.Current()), location);
            faces_without_ += made.IsNull() || made->NbTriangles() == 0;
        }
        for (RWMesh_FaceIterator face(label, TopLoc_Location(), true, style); face.More(); face.Next()) {
            if (face.IsEmptyMesh()) {
                continue;
            }
            Colour colour = kClay;
            if (face.HasFaceColor()) {
                const Quantity_ColorRGBA rgba = face.FaceColor();
                colour = {{static_cast<float>(rgba.GetRGB().Red()), static_cast<float>(rgba.GetRGB().Green()),
                           static_cast<float>(rgba.GetRGB().Blue()), rgba.Alpha()}};
            }
            Group& group = groups[colour];
            const uint32_t base = static_cast<uint32_t>(group.positions.size() / 3);
            group.has_normals = group.has_normals && face.HasNormals();
            for (int k = face.NodeLower(); k <= face.NodeUpper(); ++k) {
                push(group.positions, face.NodeTransformed(k).XYZ());
                if (face.HasNormals()) {
                    push(group.normals, face.NormalTransformed(k).XYZ());
                }
            }
            for (int k = face.ElemLower(); k <= face.ElemUpper(); ++k) {
                const Poly_Triangle triangle = face.TriangleOriented(k);
                for (int corner = 1; corner <= 3; ++corner) {
                    group.indices.push_back(base + static_cast<uint32_t>(triangle.Value(corner) - face.NodeLower()));
                }
            }
        }
    }

    static void push(std::vector<float>& to, const gp_XYZ& v) {
        for (const double value : {v.X(), v.Y(), v.Z()}) {
            if (!(std::abs(value) < 1e30)) {
                throw Failure("a point of the model is not finite");
            }
            to.push_back(static_cast<float>(value));
        }
    }

    // Curves that bound no surface, as lines.
    void curves(const TopoDS_Shape& shape, Group& lines) const {
        TopTools_IndexedDataMapOfShapeListOfShape edges;
        TopExp::MapShapesAndAncestors(shape, TopAbs_EDGE, TopAbs_FACE, edges);
        for (int k = 1; k <= edges.Extent(); ++k) {
            const TopoDS_Edge edge = TopoDS::Edge(edges.FindKey(k));
            if (!edges.FindFromIndex(k).IsEmpty() || BRep_Tool::Degenerated(edge)) {
                continue;
            }
            try {
                BRepAdaptor_Curve curve(edge);
                if (!(std::abs(curve.FirstParameter()) < 1e20 && std::abs(curve.LastParameter()) < 1e20)) {
                    continue;
                }
                GCPnts_TangentialDeflection points(curve, options_.angle * M_PI / 180, deflection_);
                for (int p = 1; p <= points.NbPoints(); ++p) {
                    if (p > 1) {
                        const uint32_t next = static_cast<uint32_t>(lines.positions.size() / 3);
                        lines.indices.insert(lines.indices.end(), {next - 1, next});
                    }
                    push(lines.positions, points.Value(p).XYZ());
                }
            } catch (const Standard_Failure&) {
                // A curve without a shape in space.
            }
        }
    }

    const Options& options_;
    bool refers_elsewhere_;
    double deflection_ = 0;
    std::map<std::string, int> meshes_;
    size_t faces_ = 0, faces_without_ = 0;
};

void convert(const Options& options, int out) {
    const Sniffed sniffed = sniff(options.input);
    Message::DefaultMessenger()->ChangePrinters().Clear();
    Handle(TDocStd_Document) document;
    XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
    if (sniffed.kind == Kind::Step) {
        STEPCAFControl_Reader reader;
        transfer(reader, options, document);
    } else {
        IGESCAFControl_Reader reader;
        // Blank entities are there for construction.
        reader.SetReadVisible(true);
        transfer(reader, options, document);
    }
    if (!sniffed.is_whole) {
        std::cerr << "warning: the file is cut short: its end is missing\n";
    }
    Converter converter(options, sniffed.refers_elsewhere);
    converter.add(document);
    converter.glb.write(out);
}

// OpenCASCADE reads outside of its memory on some damaged files. Nothing of the model has been written then.
extern "C" void crashed(int) {
    const char message[] = "overcoat-step: the file is damaged: OpenCASCADE has crashed on it\n";
    const ssize_t told = ::write(STDERR_FILENO, message, sizeof(message) - 1);
    _exit(told < 0 ? 2 : 1);
}

void catch_crashes() {
    // Shapes in shapes in shapes fill the stack, of which the handler then has none.
    static char stack[1 << 16];
    stack_t own = {};
    own.ss_sp = stack;
    own.ss_size = sizeof(stack);
    sigaltstack(&own, nullptr);
    struct sigaction action = {};
    action.sa_handler = crashed;
    action.sa_flags = SA_ONSTACK | SA_RESETHAND;
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
        sigaction(signal, &action, nullptr);
    }
}

}  // namespace

int main(int argc, char** argv) {
    // Libraries speak on standard output, which is the model's.
    const int out = dup(STDOUT_FILENO);
    if (out < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) {
        std::cerr << "overcoat-step: standard output cannot be had\n";
        return 1;
    }
    catch_crashes();
    std::string message;
    try {
        convert(parse(argc, argv), out);
        // No destructor of OpenCASCADE's documents: they take as long as reading.
        std::cerr.flush();
        _exit(0);
    } catch (const Failure& failure) {
        message = failure.what();
    } catch (const Standard_Failure& failure) {
        message = std::string("OpenCASCADE: ") + failure.DynamicType()->Name() + " " + failure.GetMessageString();
    } catch (const std::bad_alloc&) {
        message = "there is not enough memory";
    } catch (const std::exception& failure) {
        message = failure.what();
    }
    std::cerr << "overcoat-step: " << message << std::endl;
    _exit(1);
}

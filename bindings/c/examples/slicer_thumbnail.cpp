// What a slicer needs where there is no OpenGL: thumbnails of the meshes that it holds, in the G-code and in the 3MF that it writes.
//
//     slicer_thumbnail plate.gcode plate.3mf
//
// The objects on the plate are made here; a slicer has them from its model. Z is up on a plate, in millimetres.

#include "overcoat.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>

using overcoat_cpp::Renderer;

namespace {

// A triangle mesh as slicers have it (stl_vertex, stl_triangle_vertex_indices), with the colour of each face's filament.
struct Object {
    std::vector<std::array<float, 3>> vertices;
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<std::array<uint8_t, 4>> colors;
    std::array<float, 3> place;
};

// A round pot of two filaments.
Object pot(float radius, float height, std::array<float, 3> place) {
    const uint32_t around = 96, up = 24;
    Object own{{}, {}, {}, place};
    for (uint32_t row = 0; row <= up; row++) {
        const float t = float(row) / up, wide = radius * (0.8f + 0.25f * std::sin(2.5f * t));
        for (uint32_t k = 0; k < around; k++) {
            const float angle = 6.2831853f * k / around;
            own.vertices.push_back({wide * std::cos(angle), wide * std::sin(angle), height * t});
        }
    }
    const std::array<uint8_t, 4> white{230, 230, 225, 255}, orange{240, 110, 30, 255};
    for (uint32_t row = 0; row < up; row++) {
        for (uint32_t k = 0; k < around; k++) {
            const uint32_t a = row * around + k, b = row * around + (k + 1) % around;
            const auto &color = row % 8 < 4 ? white : orange;
            own.triangles.push_back({a, b, b + around});
            own.triangles.push_back({a, b + around, a + around});
            own.colors.insert(own.colors.end(), 2, color);
        }
    }
    for (uint32_t end : {0u, up}) {
        const uint32_t middle = uint32_t(own.vertices.size());
        own.vertices.push_back({0, 0, end ? height : 0});
        for (uint32_t k = 0; k < around; k++) {
            const uint32_t a = end * around + k, b = end * around + (k + 1) % around;
            own.triangles.push_back(end ? std::array<uint32_t, 3>{middle, a, b} : std::array<uint32_t, 3>{middle, b, a});
            own.colors.push_back(white);
        }
    }
    return own;
}

// The objects of a plate in a world: millimetres to metres, and Z to the world's Y.
uint64_t world_of(const Renderer &renderer, const std::vector<Object> &plate) {
    uint64_t world = 0, paint = 0;
    renderer.check(overcoat_world_new(renderer, &world));
    overcoat_material plastic;
    OVERCOAT_INIT(plastic);
    plastic.roughness = 0.5f;
    renderer.check(overcoat_add_material(renderer, world, &plastic, &paint));
    for (const auto &object : plate) {
        overcoat_mesh mesh;
        OVERCOAT_INIT(mesh);
        mesh.positions = object.vertices[0].data();
        mesh.vertex_count = object.vertices.size();
        mesh.indices = object.triangles[0].data();
        mesh.triangle_count = object.triangles.size();
        mesh.face_colors = object.colors[0].data();
        uint64_t handle = 0, instance = 0;
        renderer.check(overcoat_add_mesh(renderer, world, &mesh, &handle));
        const double mm = 0.001, x = object.place[0] * mm, y = object.place[1] * mm, z = object.place[2] * mm;
        const double matrix[16] = {mm, 0, 0, 0, 0, 0, -mm, 0, 0, mm, 0, 0, x, z, -y, 1};
        renderer.check(overcoat_add_instance(renderer, world, handle, paint, matrix, &instance));
    }
    return world;
}

std::vector<uint8_t> thumbnail(const Renderer &renderer, uint64_t world, uint32_t width, uint32_t height) {
    const float from[3] = {0.5f, 0.6f, 1.0f};
    overcoat_camera camera;
    OVERCOAT_INIT(camera);
    renderer.check(overcoat_frame(renderer, world, from, float(width) / float(height), &camera));
    overcoat_picture picture;
    OVERCOAT_INIT(picture);
    picture.width = width;
    picture.height = height;
    picture.quality = OVERCOAT_QUALITY_GOOD;
    std::vector<uint8_t> pixels(size_t(width) * height * 4);
    overcoat_target target;
    OVERCOAT_INIT(target);
    target.format = OVERCOAT_RGBA8;
    target.pixels = pixels.data();
    target.length = pixels.size();
    renderer.check(overcoat_render(renderer, world, &camera, &picture, &target, nullptr));
    return renderer.png(pixels, width, height);
}

std::string base64(const std::vector<uint8_t> &bytes) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t k = 0; k < bytes.size(); k += 3) {
        const size_t left = std::min<size_t>(3, bytes.size() - k);
        uint32_t word = 0;
        for (size_t j = 0; j < 3; j++) word = word << 8 | (j < left ? bytes[k + j] : 0);
        for (size_t j = 0; j < 4; j++) text += j <= left ? digits[word >> (18 - 6 * j) & 63] : '=';
    }
    return text;
}

// The block of comments that PrusaSlicer writes and printers show: lines of 78 digits.
void write_block(std::ostream &out, const std::vector<uint8_t> &png, uint32_t width, uint32_t height) {
    const std::string text = base64(png);
    out << "\n; thumbnail begin " << width << 'x' << height << ' ' << text.size() << '\n';
    for (size_t k = 0; k < text.size(); k += 78) out << "; " << text.substr(k, 78) << '\n';
    out << "; thumbnail end\n";
}

uint32_t crc32(const std::vector<uint8_t> &bytes) {
    uint32_t crc = ~0u;
    for (uint8_t byte : bytes) {
        crc ^= byte;
        for (int k = 0; k < 8; k++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

// A ZIP archive of stored files: what a 3MF is.
class Archive {
    std::vector<uint8_t> bytes, directory;
    uint16_t count = 0;
    static void put(std::vector<uint8_t> &to, uint64_t value, int size) {
        for (int k = 0; k < size; k++) to.push_back(uint8_t(value >> 8 * k));
    }

public:
    void add(const std::string &name, const std::vector<uint8_t> &content) {
        const uint32_t at = uint32_t(bytes.size()), size = uint32_t(content.size()), crc = crc32(content);
        auto head = [&](std::vector<uint8_t> &to) {
            put(to, 20, 2), put(to, 0, 4), put(to, 0, 2), put(to, 33, 2);
            put(to, crc, 4), put(to, size, 4), put(to, size, 4), put(to, name.size(), 2), put(to, 0, 2);
        };
        put(bytes, 0x04034b50, 4), head(bytes);
        bytes.insert(bytes.end(), name.begin(), name.end());
        bytes.insert(bytes.end(), content.begin(), content.end());
        put(directory, 0x02014b50, 4), put(directory, 20, 2), head(directory);
        put(directory, 0, 2), put(directory, 0, 2), put(directory, 0, 2), put(directory, 0, 4), put(directory, at, 4);
        directory.insert(directory.end(), name.begin(), name.end());
        count++;
    }
    void add(const std::string &name, const std::string &text) { add(name, std::vector<uint8_t>(text.begin(), text.end())); }
    std::vector<uint8_t> finish() {
        std::vector<uint8_t> out = bytes;
        out.insert(out.end(), directory.begin(), directory.end());
        put(out, 0x06054b50, 4), put(out, 0, 4), put(out, count, 2), put(out, count, 2);
        put(out, directory.size(), 4), put(out, bytes.size(), 4), put(out, 0, 2);
        return out;
    }
};

std::string model_of(const std::vector<Object> &plate) {
    std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n<resources>\n";
    std::string build;
    char line[200];
    for (size_t k = 0; k < plate.size(); k++) {
        xml += "<object id=\"" + std::to_string(k + 1) + "\" type=\"model\"><mesh><vertices>\n";
        for (const auto &[x, y, z] : plate[k].vertices) {
            std::snprintf(line, sizeof line, "<vertex x=\"%g\" y=\"%g\" z=\"%g\"/>\n", x, y, z);
            xml += line;
        }
        xml += "</vertices><triangles>\n";
        for (const auto &[a, b, c] : plate[k].triangles) {
            std::snprintf(line, sizeof line, "<triangle v1=\"%u\" v2=\"%u\" v3=\"%u\"/>\n", a, b, c);
            xml += line;
        }
        xml += "</triangles></mesh></object>\n";
        const auto &[x, y, z] = plate[k].place;
        std::snprintf(line, sizeof line, "<item objectid=\"%zu\" transform=\"1 0 0 0 1 0 0 0 1 %g %g %g\"/>\n", k + 1, x, y, z);
        build += line;
    }
    return xml + "</resources>\n<build>\n" + build + "</build>\n</model>\n";
}

bool write(const char *path, const std::vector<uint8_t> &bytes) {
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char *>(bytes.data()), std::streamsize(bytes.size()));
    return bool(out.flush());
}

}  // namespace

int main(int count, char **arguments) {
    if (count != 3) {
        std::cerr << "usage: slicer_thumbnail OUT.gcode OUT.3mf\n";
        return 2;
    }
    try {
        const std::vector<Object> plate{pot(18, 50, {100, 100, 0}), pot(12, 28, {142, 112, 0}), pot(9, 18, {118, 140, 0})};
        const Renderer renderer;
        const uint64_t world = world_of(renderer, plate);

        std::ofstream gcode(arguments[1]);
        gcode << "; generated by slicer_thumbnail\n";
        for (const auto &[width, height] : {std::pair{16u, 16u}, std::pair{220u, 124u}}) {
            write_block(gcode, thumbnail(renderer, world, width, height), width, height);
        }
        gcode << "G28\n";
        if (!gcode.flush()) throw std::runtime_error(std::string(arguments[1]) + ": cannot write");

        Archive package;
        package.add("[Content_Types].xml", std::string(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">"
            "<Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
            "<Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>"
            "<Default Extension=\"png\" ContentType=\"image/png\"/></Types>\n"));
        package.add("_rels/.rels", std::string(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
            "<Relationship Target=\"/3D/3dmodel.model\" Id=\"rel-1\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>"
            "<Relationship Target=\"/Metadata/thumbnail.png\" Id=\"rel-2\" Type=\"http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail\"/>"
            "</Relationships>\n"));
        package.add("Metadata/thumbnail.png", thumbnail(renderer, world, 256, 256));
        package.add("3D/3dmodel.model", model_of(plate));
        if (!write(arguments[2], package.finish())) throw std::runtime_error(std::string(arguments[2]) + ": cannot write");
    } catch (const std::exception &error) {
        std::cerr << "slicer_thumbnail: " << error.what() << '\n';
        return 1;
    }
}

"""The OpenGL shaders of peer_llvmpipe.py: Unity's URP with a clear coat, one light and an environment.

`vertex(textured)` and `fragment(environment, textured)` give the text. Without textures everything that is constant over
the mesh comes in uniforms; with them it is worked out for each pixel, as URP does, and the coat keeps the normal of the
mesh, as glTF has it where a coat names no normal map.
"""

# Mip levels of the environment that roughness spans: all but the smallest, in which the sphere would be a few texels.
ROUGHNESS_LEVELS = 6

VERTEX = """
uniform mat4 clip_from_world;
in vec3 position;
in vec3 normal;
out vec3 world;
out vec3 direction;
#if TEXTURED
in vec2 coordinates;
in vec4 tangent;
out vec2 place;
out vec4 along;
#endif
void main() {
    world = position;
    direction = normal;
#if TEXTURED
    place = coordinates;
    along = tangent;
#endif
    gl_Position = clip_from_world * vec4(position, 1.0);
}
"""

FRAGMENT = """
uniform vec3 eye;
uniform vec3 light;
uniform vec3 light_color;
uniform vec4 coat_lobe;
uniform float coat;
in vec3 world;
in vec3 direction;
out vec4 color;

// What depends on roughness alone. x: roughness squared less one, y: roughness squared, z: four times roughness plus two,
// w: level of the environment.
#if TEXTURED
uniform sampler2D base_color_map;
uniform sampler2D normal_map;
uniform sampler2D packed_map;
in vec2 place;
in vec4 along;
vec3 diffuse_color;
vec3 specular_color;
float grazing;
vec4 base_lobe;
float occlusion;

void read_material() {
    vec3 albedo = texture(base_color_map, place).rgb;
    vec3 packed_texel = texture(packed_map, place).rgb;
    float perceptual = packed_texel.g;
    float metallic = packed_texel.b;
    float reflectivity = 0.04 + 0.96 * metallic;
    occlusion = packed_texel.r;
    diffuse_color = albedo * (1.0 - reflectivity);
    // What lies under a coat reflects less and looks rougher.
    vec3 f0 = mix(vec3(0.04), albedo, metallic);
    vec3 under = clamp(f0 * (0.326846 + (0.978946 - 0.283835 * f0) * f0) - 0.0256868, 0.0, 1.0);
    specular_color = mix(f0, under, coat);
    grazing = min(1.0 - perceptual + reflectivity, 1.0);
    float index_ratio = mix(1.0, 1.0 / 1.5, coat);
    float square = perceptual * perceptual;
    float steepness = max(2.0 / (square * square + 1e-7) - 2.0, 0.0) / (index_ratio * index_ratio);
    perceptual = sqrt(sqrt(2.0 / (steepness + 2.0)));
    float roughness = max(perceptual * perceptual, 0.0078125);
    square = roughness * roughness;
    base_lobe = vec4(square - 1.0, square, 4.0 * roughness + 2.0, perceptual * (1.7 - 0.7 * perceptual) * LEVELS);
}

vec3 mapped_normal() {
    vec3 texel = texture(normal_map, place).xyz * 2.0 - 1.0;
    vec3 across = cross(direction, along.xyz) * along.w;
    return normalize(along.xyz * texel.x + across * texel.y + direction * texel.z);
}
#else
uniform vec3 diffuse_color;
uniform vec3 specular_color;
uniform float grazing;
uniform vec4 base_lobe;
const float occlusion = 1.0;
#endif

#if ENVIRONMENT
uniform sampler2D surroundings;
uniform vec3 harmonics[9];

vec3 irradiance(vec3 n) {
    return harmonics[0] + harmonics[1] * n.y + harmonics[2] * n.z + harmonics[3] * n.x
        + harmonics[4] * (n.x * n.y) + harmonics[5] * (n.y * n.z) + harmonics[6] * (3.0 * n.z * n.z - 1.0)
        + harmonics[7] * (n.x * n.z) + harmonics[8] * (n.x * n.x - n.y * n.y);
}

// The sphere unfolded on a square: no dearer than a lookup by angles, and without poles.
vec2 unfolded(vec3 d) {
    d /= abs(d.x) + abs(d.y) + abs(d.z);
    vec2 low = (1.0 - abs(d.zx)) * vec2(d.x < 0.0 ? -1.0 : 1.0, d.z < 0.0 ? -1.0 : 1.0);
    return (d.y < 0.0 ? low : d.xz) * 0.5 + 0.5;
}
#endif

float lobe(vec4 l, float n_h, float l_h) {
    float d = n_h * n_h * l.x + 1.00001;
    return l.y / (d * d * max(0.1, l_h * l_h) * l.z);
}

// (1 - N.V)^4
float rim_of(vec3 n, vec3 v) {
    float rim = 1.0 - clamp(dot(n, v), 0.0, 1.0);
    rim *= rim;
    return rim * rim;
}

void main() {
    vec3 coat_n = normalize(direction);
    vec3 n = coat_n;
#if TEXTURED
    read_material();
    n = mapped_normal();
#endif
    vec3 v = normalize(eye - world);
    vec3 h = normalize(light + v);
    float n_l = clamp(dot(n, light), 0.0, 1.0);
    float n_h = clamp(dot(n, h), 0.0, 1.0);
    float coat_n_l = clamp(dot(coat_n, light), 0.0, 1.0);
    float coat_n_h = clamp(dot(coat_n, h), 0.0, 1.0);
    float l_h = clamp(dot(light, h), 0.0, 1.0);
    float coat_rim = rim_of(coat_n, v);
    float covered = coat * (0.04 + 0.96 * coat_rim);

    vec3 base = diffuse_color + specular_color * lobe(base_lobe, n_h, l_h);
    float reflected = coat * 0.04 * lobe(coat_lobe, coat_n_h, l_h) * coat_n_l;
    vec3 sum = (base * ((1.0 - covered) * n_l) + reflected) * light_color;
#if ENVIRONMENT
    vec3 blurred = textureLod(surroundings, unfolded(reflect(-v, n)), base_lobe.w).rgb;
    vec3 sharp = textureLod(surroundings, unfolded(reflect(-v, coat_n)), coat_lobe.w).rgb;
    vec3 around = diffuse_color * irradiance(n)
        + blurred * mix(specular_color, vec3(grazing), rim_of(n, v)) / (base_lobe.y + 1.0);
    sum += (around * (1.0 - covered) + coat * sharp * mix(0.04, 1.0, coat_rim) / (coat_lobe.y + 1.0)) * occlusion;
#endif

    // Khronos PBR neutral, then the curve of sRGB as a power.
    float low = min(sum.r, min(sum.g, sum.b));
    sum -= low < 0.08 ? low - 6.25 * low * low : 0.04;
    float peak = max(sum.r, max(sum.g, sum.b));
    if (peak > 0.76) {
        float pressed = 1.0 - 0.0576 / (peak - 0.52);
        float gray = 1.0 / (0.15 * (peak - pressed) + 1.0);
        sum = mix(vec3(pressed), sum * (pressed / peak), gray);
    }
    color = vec4(pow(sum, vec3(1.0 / 2.2)), 1.0);
}
"""


def head(environment, textured):
    names = {"ENVIRONMENT": int(environment), "TEXTURED": int(textured), "LEVELS": f"{ROUGHNESS_LEVELS}.0"}
    return "#version 330 core\n" + "".join(f"#define {name} {value}\n" for name, value in names.items())


def vertex(textured):
    return head(False, textured) + VERTEX


def fragment(environment, textured):
    return head(environment, textured) + FRAGMENT

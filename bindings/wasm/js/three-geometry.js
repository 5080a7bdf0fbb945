// Geometries of three.js, as they are posed, as meshes of arrays.

const BY = 3;

/** One attribute as floats, whatever its type and layout. */
function floats(attribute, width) {
  const out = new Float32Array(attribute.count * width);
  const get = ["getX", "getY", "getZ", "getW"];
  for (let k = 0; k < attribute.count; k++) {
    for (let c = 0; c < width; c++) out[k * width + c] = c < attribute.itemSize ? attribute[get[c]](k) : 1;
  }
  return out;
}

/** Adds the morph targets of an object to an attribute of its geometry. */
function morphed(object, name, values) {
  const { morphAttributes = {}, morphTargetsRelative } = object.geometry;
  const targets = morphAttributes[name];
  const influences = object.morphTargetInfluences;
  if (!targets || !influences) return values;
  const base = values.slice();
  targets.forEach((target, t) => {
    const influence = influences[t] ?? 0;
    if (influence === 0) return;
    const moved = floats(target, BY);
    for (let k = 0; k < values.length; k++) values[k] += influence * (morphTargetsRelative ? moved[k] : moved[k] - base[k]);
  });
  return values;
}

/** A point as an object of three.js; its own class is that of positions of objects. */
const vector = (object) => object.position.clone().set(0, 0, 0);

/** Moves positions and normals by the bones of a skin. Bones are blends of affine maps: a normal is what lies between two points. */
function skinned(object, positions, normals) {
  const [point, tip] = [vector(object), vector(object)];
  for (let k = 0; k < positions.length / BY; k++) {
    point.fromArray(positions, k * BY);
    if (normals !== undefined) tip.fromArray(normals, k * BY).add(point);
    object.applyBoneTransform(k, point);
    point.toArray(positions, k * BY);
    if (normals !== undefined) {
      object.applyBoneTransform(k, tip);
      tip.sub(point).normalize().toArray(normals, k * BY);
    }
  }
}

/** Positions and normals of an object where its skin and its morph targets have brought them. */
function posed(object, isFlat) {
  const { attributes } = object.geometry;
  const positions = morphed(object, "position", floats(attributes.position, BY));
  const normals = isFlat || !attributes.normal ? undefined : morphed(object, "normal", floats(attributes.normal, BY));
  if (object.isSkinnedMesh) skinned(object, positions, normals);
  return { positions, normals };
}

/** The vertices that are drawn, in their order: of the index or all, within the range. */
function drawnVertices({ index, attributes, drawRange }, group) {
  const count = index ? index.count : attributes.position.count;
  const start = Math.max(drawRange.start, group?.start ?? 0);
  const end = Math.min(count, drawRange.start + drawRange.count, group === undefined ? Infinity : group.start + group.count);
  const found = new Uint32Array(Math.max(end - start, 0));
  for (let k = 0; k < found.length; k++) found[k] = index ? index.getX(start + k) : start + k;
  return found;
}

/** Pairs of the vertices of a line. */
function pairs(object, vertices) {
  if (object.isLineSegments) return vertices.subarray(0, vertices.length - (vertices.length % 2));
  const ends = object.isLineLoop ? vertices.length : vertices.length - 1;
  const found = new Uint32Array(Math.max(2 * ends, 0));
  for (let k = 0; k < ends; k++) found.set([vertices[k], vertices[(k + 1) % vertices.length]], 2 * k);
  return found;
}

/** The mesh of an object, or of the group of its geometry that is of one material; `undefined` of nothing. */
export function meshOf(object, material, channel, group) {
  const { geometry } = object;
  if (!geometry?.attributes?.position) return undefined;
  const vertices = drawnVertices(geometry, group);
  const kind = object.isPoints ? "points" : object.isLine ? "lines" : "triangles";
  let indices = kind === "lines" ? pairs(object, vertices) : vertices;
  if (kind === "triangles") indices = indices.subarray(0, indices.length - (indices.length % 3));
  if (indices.length === 0) return undefined;
  const mesh = { ...posed(object, material.flatShading || kind !== "triangles"), indices, kind };
  if (mesh.normals === undefined) delete mesh.normals;
  const uv = geometry.attributes[channel === 0 ? "uv" : `uv${channel}`];
  if (uv && kind === "triangles") mesh.uvs = floats(uv, 2);
  if (material.vertexColors && geometry.attributes.color) mesh.colors = floats(geometry.attributes.color, 4);
  return mesh;
}

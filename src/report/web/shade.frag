#version 300 es
// The colour of every pixel, as `mesotex render --shading pixel`: each vertex of the triangle is evaluated at its own
// texture coordinate continued to the point, and the three are blended by the point's barycentric weights.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
precision highp sampler2DArray;
precision highp usampler2DArray;

uniform usampler2D seen;
uniform usampler2D triangles;
uniform sampler2D vertices;
// Lists of (index, weight) per vertex, or per cell of directions, in layers of four.
uniform usampler2DArray views;
uniform usampler2DArray lights;
// Images as tiles with a border of one texel.
uniform sampler2DArray images;
uniform ivec2 grid;
uniform vec2 mapGrid;
uniform bool tileable;
uniform bool smoothTexels;
uniform bool scattered;
// Lists are those of cells: see weights.frag.
uniform bool byDirection;
uniform bool hasBorder;
uniform vec3 light;
uniform float irradiance;
uniform float background;
// What corners' shares are lowered by while something moves: see weights.frag.
uniform float lowered;

uniform vec3 eye;
// The point of the image plane that a pixel looks through, from the eye: corner + x·right + y·up.
uniform vec3 corner;
uniform vec3 right;
uniform vec3 up;

out vec4 color;

const int LAYERS = 4;

const float UNIT = 1.0 / 16384.0;
const float KNEE = 0.6;

// An image at a place of the grid, in texels from the upper left. Where it lies: see weights.frag.
vec3 imageAt(uint layer, uint tile, vec2 place) {
  ivec2 at = ivec2(tile & 255u, tile >> 8);
  if (scattered) {
    layer = tile >> 6;
    at = ivec2(tile & 7u, tile >> 3 & 7u);
  }
  at *= grid + 2;
  if (!smoothTexels) return texelFetch(images, ivec3(at + 1 + ivec2(place), layer), 0).rgb;
  return textureLod(images, vec3((vec2(at + 1) + place) / vec2(textureSize(images, 0).xy), float(layer)), 0.0).rgb;
}

// Four images of a list; a scattered sample's list goes on where views stand else.
uvec4 columnsAt(ivec2 at, int layer) {
  return layer < LAYERS ? texelFetch(lights, ivec3(at, layer), 0)
                        : texelFetch(views, ivec3(at, layer - LAYERS), 0);
}

// The blend of one view's images by the list at a place.
vec3 blendRow(ivec2 at, uint layer, vec2 place) {
  vec3 sum = vec3(0.0);
  for (int j = 0; j < (scattered ? 2 * LAYERS : LAYERS); j++) {
    uvec4 columns = columnsAt(at, j);
    for (int b = 0; b < 4; b++) {
      if (columns[b] == 0u) return sum;
      sum += float(columns[b] & 65535u) * imageAt(layer, columns[b] >> 16, place);
    }
  }
  return sum;
}

// The blend of images at a place of the grid, by the lists at two places.
vec3 blend(ivec2 viewAt, ivec2 lightAt, vec2 place) {
  if (scattered) return UNIT * blendRow(lightAt, 0u, place);
  vec3 total = vec3(0.0);
  for (int i = 0; i < LAYERS; i++) {
    uvec4 rows = texelFetch(views, ivec3(viewAt, i), 0);
    for (int a = 0; a < 4; a++) {
      if (rows[a] == 0u) return UNIT * UNIT * total;
      total += float(rows[a] & 65535u) * blendRow(lightAt, rows[a] >> 16, place);
    }
  }
  return UNIT * UNIT * total;
}

// The cell of a direction, in the last row below the horizon.
ivec2 cellOf(vec3 direction) {
  int side = textureSize(views, 0).x;
  if (direction.z < 0.0) return ivec2(0, side);
  vec2 place = 0.5 + 0.5 * direction.xy / sqrt(1.0 + direction.z);
  return clamp(ivec2(place * float(side)), ivec2(0), ivec2(side - 1));
}

ivec2 addressOf(int vertex) {
  int width = textureSize(vertices, 0).x / 3;
  return ivec2(vertex % width, vertex / width);
}

vec3 positionOf(int vertex) {
  ivec2 at = addressOf(vertex);
  return texelFetch(vertices, ivec2(3 * at.x, at.y), 0).xyz;
}

vec3 atVertex(int vertex, vec3 p) {
  ivec2 at = addressOf(vertex);
  vec4 position = texelFetch(vertices, ivec2(3 * at.x, at.y), 0);
  vec4 along = texelFetch(vertices, ivec2(3 * at.x + 1, at.y), 0);
  vec3 across = texelFetch(vertices, ivec2(3 * at.x + 2, at.y), 0).xyz;
  vec3 offset = p - position.xyz;
  vec2 coord = vec2(position.w + dot(offset, along.xyz), along.w + dot(offset, across));
  vec2 place = vec2(coord.x, mapGrid.y - coord.y) / mapGrid;
  place = vec2(grid) * (tileable ? fract(place) : place);
  place = clamp(place, vec2(0.0), vec2(grid) - 1e-3);
  if (!byDirection) return blend(at, at, place);
  vec3 s = normalize(along.xyz), t = normalize(across), normal = cross(s, t);
  vec3 towardsEye = normalize(eye - position.xyz);
  if (hasBorder && dot(normal, towardsEye) < 0.0) normal = -normal;
  vec3 view = normalize(vec3(dot(s, towardsEye), dot(t, towardsEye), max(0.0, dot(normal, towardsEye))));
  return blend(cellOf(view), cellOf(vec3(dot(s, light), dot(t, light), dot(normal, light))), place);
}

vec3 srgb(vec3 linear) {
  vec3 x = clamp(linear, 0.0, 1.0);
  return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, vec3(lessThanEqual(x, vec3(0.0031308))));
}

// As it is up to the knee; what is brighter comes ever nearer to 1, as `--tone soft` of `mesotex render`.
vec3 toned(vec3 linear) {
  vec3 bright = 1.0 - (1.0 - KNEE) * exp((KNEE - linear) / (1.0 - KNEE));
  return mix(linear, bright, vec3(greaterThan(linear, vec3(KNEE))));
}

void main() {
  uint triangle = texelFetch(seen, ivec2(gl_FragCoord.xy), 0).r;
  vec3 linear = vec3(background);
  if (triangle != 0u) {
    int index = int(triangle - 1u), width = textureSize(triangles, 0).x;
    ivec3 corners = ivec3(texelFetch(triangles, ivec2(index % width, index / width), 0).rgb);
    vec3 ray = corner + gl_FragCoord.x * right + gl_FragCoord.y * up;
    vec3 a = positionOf(corners.x), ab = positionOf(corners.y) - a, ac = positionOf(corners.z) - a;
    vec3 q = cross(eye - a, ab), r = cross(ray, ac);
    float scale = 1.0 / dot(ab, r);
    vec2 share = clamp(scale * vec2(dot(eye - a, r), dot(ray, q)), 0.0, 1.0);
    share /= max(1.0, share.x + share.y);
    vec3 p = a + share.x * ab + share.y * ac;
    vec3 shares = max(vec3(1.0 - share.x - share.y, share) - lowered, 0.0);
    shares /= shares.x + shares.y + shares.z;
    linear = vec3(0.0);
    for (int k = 0; k < 3; k++) if (shares[k] > 0.0) linear += shares[k] * atVertex(corners[k], p);
    linear = toned(linear * irradiance);
  }
  color = vec4(srgb(linear), 1.0);
}

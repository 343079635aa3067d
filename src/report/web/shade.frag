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
// Lists of (index, weight) per vertex, in layers of four.
uniform usampler2DArray views;
uniform usampler2DArray lights;
// Images as tiles with a border of one texel.
uniform sampler2DArray images;
uniform ivec2 grid;
uniform vec2 mapGrid;
uniform bool tileable;
uniform bool smoothTexels;
uniform bool scattered;
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
uvec4 columnsAt(ivec2 vertex, int layer) {
  return layer < LAYERS ? texelFetch(lights, ivec3(vertex, layer), 0)
                        : texelFetch(views, ivec3(vertex, layer - LAYERS), 0);
}

// The blend of a vertex' images of one view.
vec3 blendRow(ivec2 vertex, uint layer, vec2 place) {
  vec3 sum = vec3(0.0);
  for (int j = 0; j < (scattered ? 2 * LAYERS : LAYERS); j++) {
    uvec4 columns = columnsAt(vertex, j);
    for (int b = 0; b < 4; b++) {
      if (columns[b] == 0u) return sum;
      sum += float(columns[b] & 65535u) * imageAt(layer, columns[b] >> 16, place);
    }
  }
  return sum;
}

// The blend of a vertex' images at a place of the grid.
vec3 blend(ivec2 vertex, vec2 place) {
  if (scattered) return UNIT * blendRow(vertex, 0u, place);
  vec3 total = vec3(0.0);
  for (int i = 0; i < LAYERS; i++) {
    uvec4 rows = texelFetch(views, ivec3(vertex, i), 0);
    for (int a = 0; a < 4; a++) {
      if (rows[a] == 0u) return UNIT * UNIT * total;
      total += float(rows[a] & 65535u) * blendRow(vertex, rows[a] >> 16, place);
    }
  }
  return UNIT * UNIT * total;
}

vec3 atVertex(int vertex, vec3 p) {
  int width = textureSize(views, 0).x;
  ivec2 at = ivec2(vertex % width, vertex / width);
  vec4 position = texelFetch(vertices, ivec2(3 * at.x, at.y), 0);
  vec4 along = texelFetch(vertices, ivec2(3 * at.x + 1, at.y), 0);
  vec3 across = texelFetch(vertices, ivec2(3 * at.x + 2, at.y), 0).xyz;
  vec3 offset = p - position.xyz;
  vec2 coord = vec2(position.w + dot(offset, along.xyz), along.w + dot(offset, across));
  vec2 place = vec2(coord.x, mapGrid.y - coord.y) / mapGrid;
  place = vec2(grid) * (tileable ? fract(place) : place);
  return blend(at, clamp(place, vec2(0.0), vec2(grid) - 1e-3));
}

vec3 srgb(vec3 linear) {
  vec3 x = clamp(linear, 0.0, 1.0);
  return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, vec3(lessThanEqual(x, vec3(0.0031308))));
}

void main() {
  uint triangle = texelFetch(seen, ivec2(gl_FragCoord.xy), 0).r;
  vec3 linear = vec3(background);
  if (triangle != 0u) {
    int index = int(triangle - 1u), width = textureSize(triangles, 0).x;
    ivec3 corners = ivec3(texelFetch(triangles, ivec2(index % width, index / width), 0).rgb);
    vec3 ray = corner + gl_FragCoord.x * right + gl_FragCoord.y * up;
    int across = textureSize(views, 0).x;
    vec3 a = texelFetch(vertices, ivec2(3 * (corners.x % across), corners.x / across), 0).xyz;
    vec3 ab = texelFetch(vertices, ivec2(3 * (corners.y % across), corners.y / across), 0).xyz - a;
    vec3 ac = texelFetch(vertices, ivec2(3 * (corners.z % across), corners.z / across), 0).xyz - a;
    vec3 q = cross(eye - a, ab), r = cross(ray, ac);
    float scale = 1.0 / dot(ab, r);
    vec2 share = clamp(scale * vec2(dot(eye - a, r), dot(ray, q)), 0.0, 1.0);
    share /= max(1.0, share.x + share.y);
    vec3 p = a + share.x * ab + share.y * ac;
    vec3 shares = max(vec3(1.0 - share.x - share.y, share) - lowered, 0.0);
    shares /= shares.x + shares.y + shares.z;
    linear = vec3(0.0);
    for (int k = 0; k < 3; k++) if (shares[k] > 0.0) linear += shares[k] * atVertex(corners[k], p);
    linear *= irradiance;
  }
  color = vec4(srgb(linear), 1.0);
}

#version 300 es
// The nearest sampled directions of every vertex and their weights: the rule `continuous` (docs/rendering.md).
// A fragment is a vertex, or a cell of directions. ROLE is VIEWS, LIGHTS or PAIRS; PAIRS are the images of a scattered
// sample.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

// Per vertex 3 texels: position and s; orientation over texel and t; t axis over texel and the visible side's bound.
uniform sampler2D vertices;
uniform sampler2D normals;
// Row by row the cells of the hemisphere: the directions that may be near, each with its index, up to one below 0.
uniform sampler2D candidates;
// One pair per column: its view, its light.
uniform sampler2D pairs;
uniform int tilesAcross;
uniform vec3 eye;
uniform vec3 light;
uniform bool hasBorder;
uniform int count;
// Above 0: a fragment is one of side × side cells over the equal-area disc, or below the horizon in a last row.
uniform int side;
// The even environment's column and its weight.
uniform int environmentColumn;
uniform float environment;
// Entries that another list holds already.
uniform int skip;
// What every share is lowered by while something moves: fewer images count, and none comes or goes at once.
uniform float lowered;

layout(location = 0) out uvec4 list0;
layout(location = 1) out uvec4 list1;
layout(location = 2) out uvec4 list2;
layout(location = 3) out uvec4 list3;

const int ENTRIES = 16;
const float SAME_DIRECTION = 1e-4;
const float REACH = 1.05;
const float LARGEST_RATIO = 2.0;
// The angle above the horizon that lower views are lifted to.
const float LIFT = 1e-3;
const float PI = 3.14159265;
#if ROLE == PAIRS
const int COUNTED = 17;
#else
const int COUNTED = 5;
#endif

uint places[ENTRIES];
float weights[ENTRIES];
int used = 0;
float sum = 0.0;

// Adds an image by where it lies; weights count against the sum of `shares`.
void add(uint place, float share, float scale) {
  sum += share;
  int at = used - skip;
  if (share > 0.0) used++;
  if (share > 0.0 && at >= 0 && at < ENTRIES) {
    places[at] = place;
    weights[at] = share * scale;
  }
}

// Where an image lies: a view is a layer, a light a tile of it; of pairs 64 tiles are a layer.
uint placeOf(int index) {
#if ROLE == VIEWS
  return uint(index);
#elif ROLE == LIGHTS
  return uint(index / tilesAcross) << 8 | uint(index % tilesAcross);
#else
  return uint(index);
#endif
}

// An entry has 16 bits for where the image lies and 16 for its weight, see shade.frag. The even environment comes last.
uint entry(int at, int count) {
  if (at < count) return places[at] << 16 | max(1u, uint(min(weights[at] / sum, 3.99) * 16384.0 + 0.5));
  if (at == count && environment > 0.0) return placeOf(environmentColumn) << 16 | uint(min(environment, 3.99) * 16384.0 + 0.5);
  return 0u;
}

void finish() {
  int count = clamp(used - skip, 0, ENTRIES - 1);
  list0 = uvec4(entry(0, count), entry(1, count), entry(2, count), entry(3, count));
  list1 = uvec4(entry(4, count), entry(5, count), entry(6, count), entry(7, count));
  list2 = uvec4(entry(8, count), entry(9, count), entry(10, count), entry(11, count));
  list3 = uvec4(entry(12, count), entry(13, count), entry(14, count), entry(15, count));
}

float squaredChord(vec3 a, vec3 b) {
  vec3 chord = a - b;
  return dot(chord, chord);
}

float angleOf(float squaredChord) {
  return 2.0 * asin(min(1.0, 0.5 * sqrt(squaredChord)));
}

float angle(vec3 a, vec3 b) {
  return angleOf(squaredChord(a, b));
}

vec3 lifted(vec3 view) {
  if (view.z >= 0.0) return view;
  float level = length(view.xy);
  vec2 along = level > 0.0 ? view.xy / level : vec2(1.0, 0.0);
  return vec3(along * cos(LIFT), sin(LIFT));
}

// The row of candidates of a direction: a square of cells over the equal-area disc.
int cellOf(vec3 direction) {
  int rows = int(sqrt(float(textureSize(candidates, 0).y)));
  vec2 place = 0.5 + 0.5 * direction.xy / sqrt(1.0 + direction.z);
  ivec2 cell = clamp(ivec2(place * float(rows)), ivec2(0), ivec2(rows - 1));
  return cell.y * rows + cell.x;
}

float nearest[COUNTED];

void rank(float d) {
  for (int k = 0; k < COUNTED; k++) {
    float least = min(nearest[k], d);
    d = max(nearest[k], d);
    nearest[k] = least;
  }
}

float fading(float d, float reach) {
  float f = (reach - d) / (reach * d);
  return f * f;
}

#if ROLE == PAIRS

float distanceOf(int pair, vec3 view, vec3 towards) {
  return length(vec2(angle(view, texelFetch(pairs, ivec2(pair, 0), 0).xyz),
                     angle(towards, texelFetch(pairs, ivec2(pair, 1), 0).xyz)));
}

void weigh(vec3 view, vec3 towards) {
  for (int k = 0; k < COUNTED; k++) nearest[k] = PI * 2.0;
  for (int i = 0; i < count; i++) rank(distanceOf(i, view, towards));
  float reach = count < COUNTED ? PI : min(PI, REACH * nearest[COUNTED - 1]);
  bool takesAll = nearest[0] < SAME_DIRECTION;
  for (int i = 0; i < count; i++) {
    float d = distanceOf(i, view, towards);
    if (d >= reach || takesAll && d > nearest[0]) continue;
    float light = texelFetch(pairs, ivec2(i, 1), 0).z;
    add(placeOf(i), takesAll ? 1.0 : fading(d, reach), min(towards.z / max(light, 1e-6), LARGEST_RATIO));
  }
}

#else

// A direction's b and its coordinates x about the wanted one, over the reach.
vec3 member(vec3 wanted, vec3 other, float chord, float reach, bool takesAll, vec3 first, vec3 second) {
  float d = angleOf(chord);
  vec2 across = vec2(dot(other, first), dot(other, second));
  float sine = length(across);
  float b = takesAll ? 1.0 : d < reach ? fading(d, reach) : 0.0;
  return vec3(b, sine > 0.0 ? across * (d / (sine * reach)) : vec2(0.0));
}

float scaleOf(vec3 wanted, vec3 other) {
#if ROLE == LIGHTS
  return min(wanted.z / max(other.z, 1e-6), LARGEST_RATIO);
#else
  return 1.0;
#endif
}

// Weights that reproduce linear change: b_i (P_i A^-1 e_1) with P_i = (1, x_i), A = sum of b_i P_i^T P_i.
void weigh(vec3 wanted) {
  int row = cellOf(wanted), width = textureSize(candidates, 0).x;
  for (int k = 0; k < COUNTED; k++) nearest[k] = 4.0;
  for (int i = 0; i < width; i++) {
    vec4 other = texelFetch(candidates, ivec2(i, row), 0);
    if (other.w < 0.0) break;
    rank(squaredChord(wanted, other.xyz));
  }
  float reach = count < COUNTED ? PI : min(PI, REACH * angleOf(nearest[COUNTED - 1]));
  // A little more than the reach; what lies between has weight 0.
  float chords = reach < PI ? 1.001 * pow(2.0 * sin(0.5 * reach), 2.0) : 4.1;
  bool takesAll = angleOf(nearest[0]) < SAME_DIRECTION;
  vec3 first = normalize(abs(wanted.z) < 0.9 ? cross(wanted, vec3(0, 0, 1)) : cross(wanted, vec3(1, 0, 0)));
  vec3 second = cross(wanted, first);

  float s = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0, largest = 0.0;
  for (int i = 0; i < width; i++) {
    vec4 other = texelFetch(candidates, ivec2(i, row), 0);
    if (other.w < 0.0) break;
    float chord = squaredChord(wanted, other.xyz);
    if (chord > chords || takesAll && chord > nearest[0]) continue;
    vec3 bx = member(wanted, other.xyz, chord, reach, takesAll, first, second);
    float b = bx.x, x = bx.y, y = bx.z;
    s += b; sx += b * x; sy += b * y;
    sxx += b * x * x; sxy += b * x * y; syy += b * y * y;
    largest = max(largest, b);
  }
  vec3 plane = vec3(1.0, 0.0, 0.0);
#if LINEAR
  float steady = 1e-3 * (s + sxx + syy) / 3.0;
  mat3 moments = mat3(s, sx, sy, sx, sxx + steady, sxy, sy, sxy, syy + steady);
  plane = inverse(moments / s) * vec3(1.0, 0.0, 0.0);
#endif
  for (int i = 0; i < width; i++) {
    vec4 other = texelFetch(candidates, ivec2(i, row), 0);
    if (other.w < 0.0) break;
    float chord = squaredChord(wanted, other.xyz);
    if (chord > chords || takesAll && chord > nearest[0]) continue;
    vec3 bx = member(wanted, other.xyz, chord, reach, takesAll, first, second);
    float share = max(0.0, bx.x * dot(plane, vec3(1.0, bx.yz)) - lowered * largest);
    add(placeOf(int(other.w)), share, scaleOf(wanted, other.xyz));
  }
}

#endif

// The middle of a cell; beyond the disc the nearest direction of the horizon.
vec3 directionOf(ivec2 cell) {
  vec2 place = (2.0 * vec2(cell) + 1.0) / float(side) - 1.0;
  place /= max(1.0, length(place));
  float z = 1.0 - dot(place, place);
  return vec3(place * sqrt(1.0 + z), z);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
#if ROLE != PAIRS
  if (side > 0) {
    if (at.y < side) weigh(directionOf(at));
    finish();
    return;
  }
#endif
  vec3 normal = texelFetch(normals, at, 0).xyz;
  vec4 position = texelFetch(vertices, ivec2(3 * at.x, at.y), 0);
  vec3 s = normalize(texelFetch(vertices, ivec2(3 * at.x + 1, at.y), 0).xyz);
  vec4 across = texelFetch(vertices, ivec2(3 * at.x + 2, at.y), 0);
  vec3 t = normalize(across.xyz);
  vec3 towardsEye = normalize(eye - position.xyz);
  float facing = dot(normal, towardsEye);
  // Where no face round the vertex can be seen, nothing is read.
  bool unseen = !hasBorder && facing < across.w;
  if (hasBorder && facing < 0.0) normal = -normal;
  vec3 view = lifted(vec3(dot(s, towardsEye), dot(t, towardsEye), dot(normal, towardsEye)));
  vec3 towards = normalize(vec3(dot(s, light), dot(t, light), dot(normal, light)));
#if ROLE == VIEWS
  if (!unseen) weigh(normalize(view));
#elif ROLE == LIGHTS
  if (towards.z > 0.0) weigh(towards);
#else
  if (!unseen && towards.z > 0.0) weigh(normalize(view), towards);
#endif
  finish();
}

#version 300 es
// Which triangle each pixel sees: the provoking vertex of a triangle carries its number.
layout(location = 0) in vec3 position;
layout(location = 1) in uint triangle;
uniform mat4 clipFromWorld;
flat out uint seen;

void main() {
  seen = triangle;
  gl_Position = clipFromWorld * vec4(position, 1.0);
}

#version 300 es
precision highp int;
flat in uint seen;
layout(location = 0) out uint triangle;

void main() {
  triangle = seen + 1u;
}

#version 460
layout(location = 0) out vec2 out_place;

// Two triangles that cover the whole picture, behind everything else.
void main() {
  out_place = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0 - 1.0;
  gl_Position = vec4(out_place, 1.0, 1.0);
}

#version 460
// One triangle that covers an eye's region of the target. The region is the viewport.
layout(location = 0) out vec2 out_place;  // 0..1 over the eye's picture

void main() {
  out_place = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
  gl_Position = vec4(out_place * 2.0 - 1.0, 0.0, 1.0);
}

#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) out vec3 out_ray;

// One triangle over the whole picture, behind everything.
void main() {
  vec2 p = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0 - 1.0;
  gl_Position = vec4(p, 0.99, 1.0);
  out_ray = frame.ray_middle[VIEW].xyz + p.x * frame.ray_x[VIEW].xyz + p.y * frame.ray_y[VIEW].xyz;
}

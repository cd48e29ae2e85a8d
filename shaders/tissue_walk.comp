#version 460
#extension GL_GOOGLE_include_directive : require
// Random walks in tissue. Each element has pass.size.w walks.
#include "shaders/tissue_rays.glsl"
layout(local_size_x = 64) in;

void main() {
  int at = int(gl_GlobalInvocationID.x), slot = at / pass.size.w;
  if (slot < pass.blocks.w) exits[at] = walk(listed[slot], at - slot * pass.size.w);
}

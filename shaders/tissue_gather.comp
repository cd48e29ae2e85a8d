#version 460
#extension GL_GOOGLE_include_directive : require
// Rays from elements at the surface of tissue to the lamp and to other surfaces.
#include "shaders/tissue_rays.glsl"
layout(local_size_x = 64) in;

void main() {
  int slot = int(gl_GlobalInvocationID.x);
  if (slot < pass.blocks.w) gather(listed[slot], slot);
}

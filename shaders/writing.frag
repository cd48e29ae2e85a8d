#version 460
// A panel of writing over the composed screen, pixel for pixel as the host drew it (engine/display/writing.h).
layout(set = 0, binding = 1) readonly buffer Panels { uint pixels[]; };
layout(push_constant) uniform Push {
  ivec4 panel;  // xy: its upper left, pixels of the target; z: its width; w: its first pixel in the buffer
};
layout(location = 0) out vec4 out_color;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy) - panel.xy;
  out_color = unpackUnorm4x8(pixels[panel.w + p.y * panel.z + p.x]);
}

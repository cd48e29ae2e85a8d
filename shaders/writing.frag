#version 460
// A text panel over the composed screen. Its pixels are those that the CPU drew (engine/display/writing.h).
layout(set = 0, binding = 1) readonly buffer Panels { uint pixels[]; };
layout(push_constant) uniform Push {
  // xy: upper left corner, pixels of the target; z: width; w: index of the panel's first pixel in the buffer
  ivec4 panel;
};
layout(location = 0) out vec4 out_color;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy) - panel.xy;
  out_color = unpackUnorm4x8(pixels[panel.w + p.y * panel.z + p.x]);
}

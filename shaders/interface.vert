#version 460

// Converts the triangles of a user interface from pixels to clip space.
layout(push_constant) uniform Place {
  vec2 scale;  // size of a pixel in clip space
  vec2 shift;
  int layer;  // layer of the texture; negative: a letter, whose opacity is the red channel
};

layout(location = 0) in vec2 in_pixel;
layout(location = 1) in vec2 in_texture;
layout(location = 2) in vec4 in_color;

layout(location = 0) out vec2 out_texture;
layout(location = 1) out vec4 out_color;

void main() {
  gl_Position = vec4(in_pixel * scale + shift, 0.0, 1.0);
  out_texture = in_texture;
  out_color = in_color;
}

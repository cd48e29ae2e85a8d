#version 460

// Input and output are sRGB bytes. They are blended without conversion, because user interface colours are chosen for
// this blending.
layout(push_constant) uniform Place {
  vec2 scale;
  vec2 shift;
  int layer;
};
layout(set = 0, binding = 0) uniform sampler2DArray image;

layout(location = 0) in vec2 in_texture;
layout(location = 1) in vec4 in_color;
layout(location = 0) out vec4 out_color;

void main() {
  vec4 color = in_color;
  if (layer < 0)
    color.a *= texture(image, vec3(in_texture, 0.0)).r;
  else
    color.rgb *= texture(image, vec3(in_texture, float(layer))).rgb;
  out_color = vec4(color.rgb * color.a, color.a);
}

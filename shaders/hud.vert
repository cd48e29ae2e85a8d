#version 460
#extension GL_EXT_multiview : require

layout(location = 0) in vec4 in_place;  // xy: picture, −1..1, y up; zw: atlas
layout(location = 1) in vec4 in_color;  // sRGB, w: opacity
layout(location = 2) in vec4 in_box;    // xy: −1..1 across a box, z: aspect, w: 1 a box, 0 a letter

layout(location = 0) out vec2 out_atlas;
layout(location = 1) out vec4 out_color;
layout(location = 2) out vec4 out_box;

// Equal for both eyes: writing lies on the screen plane.
void main() {
  gl_Position = vec4(in_place.x, -in_place.y, 0.0, 1.0);
  out_atlas = in_place.zw;
  out_color = vec4(pow(in_color.rgb, vec3(2.2)), in_color.a);
  out_box = in_box;
}

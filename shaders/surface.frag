#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"
#include "filtered.glsl"
#include "cut_tissue.glsl"
#include "tooth.glsl"
#include "gum.glsl"
#include "film.glsl"
#include "temperature.glsl"

layout(location = 0) centroid in vec3 in_position;
layout(location = 1) centroid in vec4 in_normal;
layout(location = 2) centroid in vec4 in_light;  // see out_light in surface.vert
layout(location = 3) flat in uint in_pair;
layout(location = 4) centroid in vec3 in_mesh_position;
layout(location = 5) centroid in vec4 in_first;
// colour of the second tissue; w: fraction of the surface that a cut laid open
layout(location = 6) centroid in vec4 in_second;
layout(location = 7) flat in vec4 in_first_look;
layout(location = 8) flat in vec4 in_second_look;
layout(location = 9) centroid in vec3 in_room;
layout(location = 10) centroid in vec4 in_lamp;
layout(location = 11) centroid in vec3 in_half_way;
layout(location = 0) out vec4 out_color;

layout(constant_id = 6) const bool kCursor = false;  // true: the cursor's ring is drawn

/// Returns the light at a point from which the whole room is visible.
Around open_light(vec3 n, vec3 v) { return Around(ambient_light(n), ambient_light(reflect(-v, n)), vec4(0.0), 0.0); }

// result of visibility() at an open point
const vec4 kOpen = vec4(1.0);

bool holds(int what) { return (kHolds & what) != 0; }

/// Adds the cursor's ring to the colour. The inner part of the ring is light and its outer part dark, so that it is
/// visible on every tissue. There is no ring where the cursor's line leaves a body.
vec3 with_cursor(vec3 color) {
  if (!kCursor) return color;
  vec3 q = in_position - frame.cursor.xyz;
  float below = dot(q, frame.cursor_down.xyz);
  float r = length(q - below * frame.cursor_down.xyz) / frame.cursor.w;
  float edge = clamp(fwidth(r), 0.02, 0.4), width = max(0.16, 0.8 * edge);
  // On a wall along the tool, the ring would be two bars.
  float shown = step(-frame.cursor.w, below) * smoothstep(0.2, 0.5, -dot(in_normal.xyz, frame.cursor_down.xyz));
  float inner = shown * smoothstep(1.0 - width - edge, 1.0 - width, r) * (1.0 - smoothstep(1.0 - edge, 1.0, r));
  float outer = shown * smoothstep(1.0 - edge, 1.0, r) * (1.0 - smoothstep(1.0 + width, 1.0 + width + edge, r));
  color = mix(color, vec3(0.012, 0.05, 0.06), 0.7 * outer);
  return mix(color, vec3(0.20, 0.75, 0.85), 0.8 * inner);
}

void main() {
  vec3 n = normalize(in_normal.xyz);
  vec3 v = normalize(frame.eye[VIEW].xyz - in_position);
  if (kView == 4) {
    vec3 shown = temperature_picture(in_position, n, v, in_pair & 255u, in_pair >> 8, in_light.w);
    out_color = vec4(with_cursor(shown), 1.0);
    return;
  }
  if (kView == 1 && !gl_FrontFacing) {
    // A section shows the inside of a body. It is drawn like the cut face, so that the body looks closed and solid.
    n = -frame.section.xyz;
    vec4 fill = frame.tissue_color[in_pair & 255u];
    out_color = vec4(tone_map(shade(n, n, v, Look(0.85 * fill.rgb, 0.8, 0.0, kUsualDry, 0.0), kOpen, open_light(n, v))), 1.0);
    return;
  }
  if (holds(kHoldsBacks) && !gl_FrontFacing) {
    // The back of an open surface is drawn in one colour, without tissue. It is lit from the viewer's side, without the
    // surface's own shadow.
    out_color = vec4(with_cursor(tone_map(shade(-n, -n, v, Look(vec3(0.16, 0.19, 0.24), 0.9, 0.0, kUsualDry, 0.0), vec4(0.4, 0.8, 1.0, 1.0), open_light(-n, v)))), 1.0);
    return;
  }
  uint a = in_pair & 255u, b = in_pair >> 8;
  vec3 color = in_first.rgb;
  vec4 look = in_first_look;
  uint main_tissue = a;
  float fraction = 0.0;
  if (holds(kHoldsPairs)) {
    // The boundary between sound tissues is sharp to the pixel. The edge of caries is slightly softer. It is still
    // narrower than a triangle, so that the shape of triangles is not visible.
    float width = fwidth(in_light.w) + 1e-5;
    fraction = a == b ? 0.0 : clamp((in_light.w - 0.5) / width + 0.5, 0.0, 1.0);
    if (holds(kHoldsDecay) && a != b && (a == kCaries || b == kCaries)) fraction = smoothstep(0.5 - max(0.5 * width, 0.09), 0.5 + max(0.5 * width, 0.09), in_light.w);
    color = mix(color, in_second.rgb, fraction);
    look = mix(look, in_second_look, fraction);
    if (fraction > 0.5) main_tissue = b;
  }
  vec4 light = kLightPerVertex ? kOpen : visibility(in_position, n, in_lamp.x, shadow_scatter(look.w, in_lamp.z));

  if (holds(kHoldsDecay) && (a == kCaries || b == kCaries)) {
    float decay = a == b ? 1.0 : a == kCaries ? 1.0 - fraction : fraction;
    // Fractions of tissue are blurred over two voxels. So in the corner of a triangle that is surrounded by caries, the
    // fraction of caries is only about 0.8.
    float inward = a == b ? 1.0 : min((a == kCaries ? 1.0 - in_light.w : in_light.w) / 0.8, 1.0);
    color = mix(color, caries(color, in_mesh_position, inward, in_first.w), decay);
  }
  if (kView == 3 && a != kGingiva && a < kMucosa) {
    // Difference from the ideal: neutral below 0.04 mm, full colour from 0.9 mm.
    float d = in_normal.w * 2.0;  // mm, difference from the ideal
    float much = smoothstep(0.04, 0.9, abs(d)) * 0.75 + 0.25 * smoothstep(0.04, 0.08, abs(d));
    color = mix(vec3(0.62, 0.60, 0.56), d > 0.0 ? vec3(0.02, 0.12, 0.75) : vec3(0.75, 0.03, 0.02), much);
    look.xyz = vec3(0.6, kUsualDry, 0.15);
  }
  if (kGlass) {
    // Glass is transparent when it is viewed along its normal, and dense at grazing angles.
    float turn = 1.0 - abs(dot(n, v));
    float alpha = mix(0.06, 0.80, turn * turn * turn) * (main_tissue == kEnamel ? 1.0 : 0.75);
    vec3 glow = tone_map(shade(n, n, v, Look(mix(color, vec3(0.55, 0.75, 1.0), 0.35), 0.2, 0.5, kUsualDry, 0.9), kOpen, open_light(n, v)));
    out_color = vec4(glow * alpha, alpha);
    return;
  }
  vec3 mirrored = in_half_way;
  float metal = 0.0;
  if (kLightGrid && holds(kHoldsMetal)) {
    metal = metal_of(look.y);
    mirrored = mix(mirrored, mirrored_light(in_position, n, reflect(-v, n), kMirrorAtMetal), metal);
  }
  if (kLightPerVertex) {
    // The colour of metal is 0 here, because metal has no diffuse light.
    vec3 room = mix(in_room, frame.tissue_color[main_tissue].rgb * mirrored, metal);
    vec3 half_way = normalize(in_half_way);
    vec3 gloss = kView == 3 ? vec3(0.0) : room + in_lamp.rgb * lamp_image(dot(n, half_way), dot(frame.key.xyz, half_way), filtered_width(in_lamp.w, n));
    out_color = vec4(with_cursor(tone_map(color * in_light.rgb + gloss)), 1.0);
    return;
  }
  vec3 gloss_normal = n, sheen = vec3(0.0);
  if (kView != 3) {
    float pixel = length(fwidth(in_position));  // m, size of a pixel on the surface
    if (holds(kHoldsEnamel) && main_tissue == kEnamel) {
      look = surface_look(kEnamel, look, in_second.w);
      color = enamel(color, in_mesh_position, n, light.y, pixel, in_second.w, gloss_normal);
    } else if (holds(kHoldsPairs) && main_tissue == kDentin) {
      look = surface_look(kDentin, look, in_second.w);
      color = dentin(color, in_mesh_position, n, pixel, in_second.w, gloss_normal, look.x);
      if (in_second.w > 0.5) sheen = tubule_sheen(in_mesh_position, n, v, look.x, light.x);
      if (a != b && (a == kPulp || b == kPulp))
        color = bloody(color, in_mesh_position, a == kPulp ? 1.0 - in_light.w : in_light.w);
    } else if (holds(kHoldsPairs) && main_tissue == kPulp) {
      color = pulp(color, in_mesh_position, n, gloss_normal);
      look.x = 0.12;
    } else if (holds(kHoldsGum) && (main_tissue == kGingiva || main_tissue >= kMucosa)) {
      soft_surface(main_tissue, in_mesh_position, in_first.w, color, n, gloss_normal);
    }
  }
  if (kFilm && kView != 3) {
    vec4 film = film_at(in_position);
    cover_with_film(film, color, look);
    sheen *= 1.0 - max(film.y, wetness(film));
    gloss_normal = film_normal(film, gloss_normal);
  }
  Look shown = Look(color, look.x, look.w, look.y, look.z);
  vec4 inside = kLightGrid ? vec4(in_light.rgb, in_lamp.y) : vec4(0.0);
  if (kLightGrid && holds(kHoldsGum)) {
    // The grid does not contain the dimples of gum. Light inside the gum halves their contrast.
    vec3 coarse = normalize(in_normal.xyz);
    inside.rgb *= 1.0 + 0.5 * inside.w * dot(n - coarse, frame.key.xyz) / max(dot(coarse, frame.key.xyz), 0.3);
  }
  vec3 lit = shade(n, gloss_normal, v, shown, light, Around(in_room, mirrored, inside, in_lamp.z));
  if (!kLightGrid) lit += color * light.y * in_light.rgb;
  out_color = vec4(with_cursor(tone_map(lit + sheen)), 1.0);
}

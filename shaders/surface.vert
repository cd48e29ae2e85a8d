#version 460
#extension GL_EXT_multiview : require
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "lighting.glsl"
#include "film.glsl"
#include "cut_tissue.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec4 in_normal;  // xyz: normal; w: difference, in units of kDifferenceRange
// Packed bytes. x, y: the two tissues in the low bits; in the high bits, x the fraction that a cut laid open, y the
// thinness. z: 255 × fraction of the second tissue. w: the lower tissue and, in the high bits, its visible fraction.
layout(location = 2) in uvec4 in_tissue;
layout(location = 3) in vec4 in_lesion;  // x: nearness of caries; y, z: bytes of the paint's VoxelColor; w: its fraction

layout(location = 0) centroid out vec3 out_position;
layout(location = 1) centroid out vec4 out_normal;
// With light per vertex: incident light. Otherwise, with a grid of light: light_in_tissue(). Otherwise: light through
// thin tissue where nothing hides the lamp. w: fraction of the second tissue
layout(location = 2) centroid out vec4 out_light;
layout(location = 3) flat out uint out_pair;
layout(location = 4) centroid out vec3 out_mesh_position;
// colour of the first tissue over the lower tissue; w: visible fraction of the lower tissue
layout(location = 5) centroid out vec4 out_first;
// colour of the second tissue; w: fraction of the surface that a cut laid open
layout(location = 6) centroid out vec4 out_second;
layout(location = 7) flat out vec4 out_first_look;  // first tissue: roughness, dry reflectance, wetness, translucency
layout(location = 8) flat out vec4 out_second_look;
// With light per vertex: the room's reflection (out_room), the lamp's (out_lamp), and the half-way direction.
// Otherwise: grid_light() for the normal (out_room, out_lamp.x) and for the reflection (out_half_way); out_lamp.y:
// light_in_tissue().w, out_lamp.z: in_tissue_grid().
layout(location = 9) centroid out vec3 out_room;
layout(location = 10) centroid out vec4 out_lamp;  // w: width of the lamp's reflection
layout(location = 11) centroid out vec3 out_half_way;

invariant gl_Position;

/// Returns the colour of a tissue through which a lower tissue is visible. Clear tissue (enamel) does not change the
/// lower tissue's colour; other tissues tint it.
vec3 over(vec4 upper, vec3 beneath, float shows) {
  return mix(upper.rgb, beneath * mix(sqrt(upper.rgb), vec3(1.0), min(1.18 * upper.w, 1.0)), shows);
}

/// Returns the colour of a tissue, mixed with the colour of the voxels around the vertex (Vertex::paint).
vec4 painted(vec4 tissue) {
  if (in_lesion.w == 0.0) return tissue;
  uvec2 bytes = uvec2(in_lesion.yz * 255.0 + 0.5);
  uint bits = bytes.x | bytes.y << 8;
  vec3 paint = vec3(bits >> 11, bits >> 5 & 63u, bits & 31u) / vec3(31.0, 63.0, 31.0);
  return vec4(mix(tissue.rgb, linear_light(paint), in_lesion.w), tissue.w);
}

void main() {
  vec4 p = vec4(in_position, 1.0);
  vec3 world = vec3(dot(object.world_row[0], p), dot(object.world_row[1], p), dot(object.world_row[2], p));
  vec3 n = vec3(dot(object.world_row[0].xyz, in_normal.xyz), dot(object.world_row[1].xyz, in_normal.xyz),
                dot(object.world_row[2].xyz, in_normal.xyz));
  gl_Position = frame.clip_from_world[VIEW] * vec4(world, 1.0);
  gl_ClipDistance[0] = dot(frame.clip, vec4(world, 1.0));
  gl_ClipDistance[1] = dot(frame.section, vec4(world, 1.0));
  uint tissue_1 = in_tissue.x & 15u, tissue_2 = in_tissue.y & 15u;
  float cut = float(in_tissue.x >> 4) / 15.0, thin = float(in_tissue.y >> 4) / 15.0;
  out_position = world;
  out_normal = vec4(n, in_normal.w);
  out_pair = tissue_1 | (tissue_2 << 8);
  out_mesh_position = in_position;
  float share = float(in_tissue.z) / 255.0, shows = float(in_tissue.w >> 4) / 15.0;
  uint lower = in_tissue.w & 15u;
  vec3 beneath = frame.tissue_color[lower].rgb;
  vec4 first = painted(frame.tissue_color[tissue_1]);
  vec4 film = kFilm ? film_at(world) : vec4(0.0);
  float wet = kFilm ? wetness(film) : 0.0;
  vec3 layered = lower == tissue_1 ? first.rgb : over(first, beneath, shows);
  out_first = vec4(surface_color(tissue_1, layered, cut, wet, thin, shows, in_lesion.x), shows);
  out_first_look = vec4(frame.tissue_look[tissue_1].xyz, first.w);
  out_second = vec4(out_first.rgb, cut);
  out_second_look = out_first_look;
  if ((kHolds & kHoldsPairs) != 0) {
    vec4 second = painted(frame.tissue_color[tissue_2]);
    layered = lower == tissue_2 ? second.rgb : over(second, beneath, shows);
    out_second.rgb = surface_color(tissue_2, layered, cut, wet, thin, shows, in_lesion.x);
    out_second_look = vec4(frame.tissue_look[tissue_2].xyz, second.w);
  }
  out_light = vec4(kLightGrid ? vec3(0.0) : through_edge(n, thin), share);
  out_room = vec3(0.0);
  out_lamp = vec4(0.0);
  out_half_way = vec3(0.0);
  vec4 around = vec4(0.0, 0.0, 0.0, 1.0);
  vec3 mirrored = vec3(0.0);
  vec4 inside = vec4(0.0);
  float known = 0.0;
  if (kLightGrid) {
    inside = light_in_tissue(world);
    // Cells without light are empty: soft gum may move out of the cells that had a surface in the first frame.
    known = in_tissue_grid(world) * frame.tissue_look[tissue_1].w * smoothstep(0.0, 0.02, inside.r + inside.g);
    around = grid_light(world, n);
    mirrored = mirrored_light(world, n, reflect(normalize(world - frame.eye[VIEW].xyz), n), kMirrorAtTissue);
  }
  if (!kLightPerVertex) {
    out_room = around.rgb;
    out_half_way = mirrored;
    out_lamp = vec4(around.w, inside.w, known, 0.0);
    if (kLightGrid) out_light.rgb = inside.rgb;
  } else {
    if ((kHolds & kHoldsGum) != 0) out_first.rgb *= mean_texture(tissue_1), out_second.rgb *= mean_texture(tissue_2);
    vec4 light = visibility(world, n, around.w, shadow_scatter(first.w, known));
    vec3 v = normalize(frame.eye[VIEW].xyz - world);
    float nv = max(dot(n, v), 1e-3), second = tissue_1 == tissue_2 ? 0.0 : step(0.5, share);
    out_first_look = surface_look(tissue_1, out_first_look, cut);
    out_second_look = surface_look(tissue_2, out_second_look, cut);
    if (kFilm) {
      cover_with_film(film, out_first.rgb, out_first_look);
      if (tissue_1 == tissue_2 || (kHolds & kHoldsPairs) == 0)
        out_second.rgb = out_first.rgb, out_second_look = out_first_look;
      else
        cover_with_film(film, out_second.rgb, out_second_look);
    }
    vec4 look = mix(out_first_look, out_second_look, second);
    vec3 color = mix(out_first.rgb, out_second.rgb, second);
    out_first.rgb = tinted(out_first.rgb * (1.0 - metal_of(out_first_look.y)), out_first_look.w, nv);
    out_second.rgb = tinted(out_second.rgb * (1.0 - metal_of(out_second_look.y)), out_second_look.w, nv);
    Look shown = Look(color, look.x, look.w, look.y, look.z);
    out_light.rgb = film_passes(nv, shown) * arriving(n, v, color, look.w, light, around.rgb, inside, known) +
                    light.y * out_light.rgb;
    out_half_way = normalize(frame.key.xyz + v);
    CornerGloss gloss = corner_gloss(n, v, out_half_way, shown, light.xy, Around(around.rgb, mirrored, inside, known));
    out_room = gloss.broad;
    out_lamp = vec4(gloss.lamp, gloss.width);
  }
}

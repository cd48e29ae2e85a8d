// Appearance that depends on the shape of a tooth's surface and not only on its tissue: whether a cut laid the surface
// open, and how thin the tissue below it is. Include after lighting.glsl.

const uint kEnamel = 1u, kDentin = 2u, kCaries = 3u, kPulp = 4u;
// Linear reflectance, estimated: kChalk: enamel that lost mineral; kStain: enamel stained by caries; kAffected: dentin
// that bacteria softened, but did not enter.
const vec3 kChalk = vec3(0.66, 0.64, 0.58), kStain = vec3(0.24, 0.14, 0.065), kAffected = vec3(0.30, 0.16, 0.065);
const float kFrost = 0.06;  // strength of the frost on cut enamel

/// Returns the colour of a surface. `cut`: 0 natural, 1 cut; `wet`: 0 dry, 1 under water; `thin`: 1 if as thin as a
/// voxel; `shows`: visible fraction of the lower tissue; `lesion`: nearness of caries, 1 at its edge.
vec3 surface_color(uint tissue, vec3 color, float cut, float wet, float thin, float shows, float lesion) {
  if (kView != 0) return color;
  if (tissue == kEnamel) {
    // Dry cut enamel scatters light at its rough surface, so it is frosty. Water fills the roughness. The frost ends
    // gradually where the lower tissue becomes visible.
    color = mix(color, vec3(0.66, 0.66, 0.64), kFrost * cut * (1.0 - wet) * (1.0 - shows));
    // Thin enamel lets red light pass, so its edge is bluish grey.
    color *= mix(vec3(1.0), vec3(0.66, 0.78, 0.90), thin * thin);
    // Enamel that lost mineral is chalky, and stained near the caries.
    color = mix(color, kChalk, 0.6 * smoothstep(0.0, 0.5, lesion));
    color = mix(color, kStain, 0.8 * smoothstep(0.45, 0.85, lesion));
  } else if (tissue == kDentin) {
    // A natural surface of dentin is a root, covered with cementum, which is darker.
    color *= mix(vec3(0.92, 0.86, 0.84), vec3(1.0), cut);
    // Dentin that caries affected is brown.
    color = mix(color, kAffected, 0.8 * smoothstep(0.4, 0.85, lesion));
  }
  return color;
}

const uint kMucosa = 10u;

/// Returns the mean factor by which soft_surface() (gum.glsl) changes the colour of mucosa. Pictures that are lit per
/// vertex have no such texture, but get the same mean colour.
vec3 mean_texture(uint tissue) {
  return kView == 0 && tissue == kMucosa ? vec3(0.99, 0.95, 0.945) : vec3(1.0);
}

/// Returns roughness, dry reflectance, wetness and translucency of a surface. Cut enamel is dry and rough, cementum is
/// matt.
vec4 surface_look(uint tissue, vec4 look, float cut) {
  if (kView != 0) return look;
  if (tissue == kEnamel) return mix(look, vec4(0.60, look.y, 0.15, 0.45), cut);
  if (tissue == kDentin) return mix(vec4(0.85, look.y, 0.05, 0.20), look, cut);
  return look;
}

/// Returns the lamp's light that crosses thin tissue from behind, at a point from which the whole room is visible.
vec3 through_edge(vec3 n, float thin) {
  if (kView != 0) return vec3(0.0);
  float behind = max(-dot(n, frame.key.xyz), 0.0);
  return (0.45 * thin * thin * behind * frame.key.w * 0.3183) * vec3(1.0, 0.80, 0.58) * kLampColor;
}

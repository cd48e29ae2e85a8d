// Appearance of tissues. Colours come from the scene's materials; this file contains the optics.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/contract/tissue.h"
#include "engine/render/drawn_matter.h"
#include "engine/render/renderer.h"
#include "engine/render/shared.h"
#include "engine/render/srgb.h"

namespace typodont::render {

struct Look {
  dvec3 color{1, 1, 1};  // sRGB
  double roughness = 0.5;
  double translucency = 0;  // 0 (chalk) to 1 (wax)
  double metal = 0;
  double wetness = 0;  // strength of the water film on the surface
  double index = 1.5;  // refractive index
  // Reduced scattering + absorption of red, green, blue light, 1/m; infinite: opaque. Values as in
  // tests/reference/tissues.json.
  dvec3 extinction{std::numeric_limits<double>::infinity()};
};

inline std::array<Look, kMatterCount> appearances_of(const MaterialTable& materials) {
  std::array<Look, kMatterCount> looks;
  const auto set = [&](Tissue t, double roughness, double translucency, double metal, double wetness,
                       double index = 1.5) {
    const auto i = static_cast<std::size_t>(t);
    looks[i] = {materials[i].color, roughness, translucency, metal, wetness, index};
  };
  const auto scatters = [&](Tissue t, double red, double green, double blue) {
    looks[static_cast<std::size_t>(t)].extinction = 1e3 * dvec3(red, green, blue);
  };
  // Softer caries is darker. Stiffness 0.3 N/mm: the material's colour; 0.5 (nearly dentin): light brown; 0.1: black.
  const auto softness = [&] {
    const double stiffness = materials[static_cast<std::size_t>(Tissue::kCaries)].stiffness;
    return stiffness > 0 ? std::clamp(std::log2(stiffness / 300.0), -1.6, 0.9) : 0.0;
  }();
  set(Tissue::kAir, 0.5, 0.0, 0, 0);
  set(Tissue::kEnamel, 0.22, 0.85, 0, 0.90, 1.631);
  set(Tissue::kDentin, 0.62, 0.35, 0, 0.10, 1.54);
  set(Tissue::kCaries, 0.80, 0.15, 0, 0.05);
  set(Tissue::kPulp, 0.35, 0.60, 0, 0.80, 1.37);
  set(Tissue::kCorticalBone, 0.55, 0.30, 0, 0.35, 1.55);
  set(Tissue::kCancellousBone, 0.65, 0.30, 0, 0.30);
  set(Tissue::kGingiva, 0.38, 0.60, 0, 0.70, 1.40);
  set(Tissue::kAmalgam, 0.34, 0.0, 1.0, 0);
  set(Tissue::kComposite, 0.40, 0.70, 0, 0.45, 1.52);
  looks[static_cast<std::size_t>(Tissue::kCaries)].color =
      glm::min(looks[static_cast<std::size_t>(Tissue::kCaries)].color * std::exp2(0.8 * softness), dvec3(1));
  const auto drawn = [&](Tissue matter, const Look& look) { looks[static_cast<std::size_t>(matter)] = look; };
  // L* 55, a* 25, b* 12, about Munsell 5R 5.4/6. Normal oral mucosa has hue 5R to 7.5YR, value 3.5 to 6 and chroma 2 to
  // 6 (J. Stomatol. Soc. Jpn. 53 (1986) 208, matched with colour chips).
  drawn(kMucosa, {{0.705, 0.449, 0.437}, 0.30, 0.60, 0, 0.85, 1.40});
  drawn(kTongue, {{0.80, 0.50, 0.49}, 0.50, 0.60, 0, 0.55, 1.40});
  drawn(kSkin, {{0.86, 0.69, 0.59}, 0.60, 0.35, 0, 0.05, 1.40});
  drawn(kRubber, {{0.18, 0.45, 0.56}, 0.62, 0.20, 0, 0.05, 1.52});
  drawn(kAcrylic, {{0.88, 0.55, 0.56}, 0.34, 0.40, 0, 0.25, 1.49});
  drawn(kPlastic, {{0.93, 0.90, 0.82}, 0.36, 0.55, 0, 0.25, 1.49});
  scatters(Tissue::kEnamel, 0.275, 0.400, 0.695);
  scatters(Tissue::kDentin, 2.16, 2.34, 2.86);
  scatters(Tissue::kCaries, 2.8, 2.8, 2.8);
  scatters(Tissue::kPulp, 1.8, 2.1, 2.5);
  scatters(Tissue::kCorticalBone, 2.1, 2.5, 3.1);
  scatters(Tissue::kCancellousBone, 1.5, 1.8, 2.3);
  scatters(Tissue::kComposite, 1.3, 1.6, 2.1);
  scatters(Tissue::kGingiva, 1.9, 2.3, 2.9);
  scatters(kAcrylic, 3.3, 3.3, 3.3);
  scatters(kPlastic, 2.3, 2.3, 2.3);
  return looks;
}

/// Reflectance of the dry surface at normal incidence (Fresnel); 1 for metal.
inline double dry_reflectance(const Look& look) {
  const double r = (look.index - 1) / (look.index + 1);
  return look.metal > 0.5 ? 1.0 : r * r;
}

/// Fraction of diffuse light that surface or saliva reflects; 0 for metal, whose colour includes it. The result fits
/// the hemispherical mean of Fresnel's reflectance for indices 1.33 to 1.5.
inline double hemispherical_reflectance(const Look& look) {
  if (look.metal > 0.5) return 0;
  const double dry = dry_reflectance(look), filmed = shared::kFilmedLeast + shared::kFilmedSlope * dry,
               normal = glm::mix(dry, filmed, look.wetness);
  return 0.04 + 1.3 * normal;
}

/// Colour of a translucent layer over another tissue, as over() in shaders/surface.vert. `shows`: visible fraction of
/// the lower colour, 0..1.
inline dvec3 layered_color(const dvec3& upper, double translucency, const dvec3& beneath, double shows) {
  return glm::mix(upper, beneath * glm::mix(glm::sqrt(upper), dvec3(1), std::min(1.18 * translucency, 1.0)), shows);
}

/// Colour that mixes into tooth tissue of this hardness, sRGB; w: 0..1, fraction of this colour. `hardness`: 0 to 1, of
/// the tissue's own. Softened enamel is chalky, softened dentin brown. Caries has its material's colour where it is
/// softest, and is yellow-brown at its edge. All values are estimates.
inline glm::vec4 decay_paint(Tissue tissue, double hardness) {
  constexpr glm::vec3 kChalk(0.86f, 0.85f, 0.81f), kBrown(0.65f, 0.46f, 0.27f);
  constexpr double kSoftest = 0.15;  // hardness of the darkest caries
  if (hardness >= 1) return glm::vec4(0);
  const auto lost = static_cast<float>(std::min((1 - hardness) / 0.4, 1.0));
  const auto firm = static_cast<float>(std::clamp((hardness - kSoftest) / (0.9 - kSoftest), 0.0, 1.0));
  switch (tissue) {
    case Tissue::kEnamel:
      return {kChalk, 0.9f * lost};
    case Tissue::kDentin:
      return {kBrown, 0.8f * lost};
    case Tissue::kCaries:
      return {kBrown, 0.9f * firm};
    default:
      return glm::vec4(0);
  }
}

/// A tissue's linear colour, mixed with the colour of the voxels around a vertex (Vertex::paint).
inline dvec3 painted_color(const dvec3& tissue, const glm::vec4& paint) {
  if (!(paint.w > 0)) return tissue;
  return glm::mix(tissue, linear_light(dvec3(paint)), static_cast<double>(paint.w));
}

/// Mean free path of red, green, blue light at a vertex, m; 0: opaque. Shorter in thin enamel, because the tissue below
/// scatters too.
inline dvec3 free_path(const std::array<Look, kMatterCount>& looks, const Vertex& v) {
  constexpr double kUsualEnamel = 1.2e-3;  // m, thickness on a molar, if the vertex states none
  const Tissue outer = v.tissue[v.second > 0.5f];
  const dvec3 path = 1.0 / looks[static_cast<std::size_t>(outer)].extinction;
  const bool usual = v.under == Tissue::kAir;
  if (outer != Tissue::kDentin && outer != Tissue::kEnamel) return path;
  if ((usual && outer == Tissue::kDentin) || v.under == outer) return path;
  const dvec3 below = 1.0 / looks[static_cast<std::size_t>(usual ? Tissue::kDentin : v.under)].extinction;
  return glm::min(below + 0.5 * std::max(usual ? kUsualEnamel : static_cast<double>(v.depth), 0.02e-3), path);
}

}  // namespace typodont::render

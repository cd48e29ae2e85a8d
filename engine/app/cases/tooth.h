// A whole tooth from published sizes (assets/cases/teeth.json) and a seed: crown, roots, enamel, pulp.
#pragma once

#include <string>
#include <vector>

#include "engine/app/surroundings/tooth_form.h"
#include "engine/base/split_mix.h"
#include "haptics/dense_tissue.h"

namespace typodont {

/// 0..1.
double uniform(SplitMix64& random);

/// A tapered tube; round, or elliptic by `stretch_y`.
struct TaperedTube {
  dvec3 a{0}, b{0};  // m, ends
  double radius_a = 0, radius_b = 0;
  double stretch_y = 1;
  double distance(const dvec3& p) const;
};

/// Frame of ToothForm: x mesial, y buccal, z out of the crown, origin in the neck. m.
struct CaseTooth {
  std::string type;  // "L6": lower first molar
  std::string name;
  double age = 0;  // years, of the pulp
  double md = 0, bl = 0, crown = 0, root = 0;
  ToothForm form;
  ToothForm blunt;       // without grooves: where the enamel ends
  double furcation = 0;  // m below the neck; 0: one root
  std::vector<TaperedTube> roots;
  double cej_mesial = 0, cej_distal = 0;       // m, rise of the enamel's edge
  double enamel = 0;                           // m, thickness in the occlusal third
  std::vector<TaperedTube> pulp;               // chamber, horns, canals
  double chamber_roof = 0, chamber_floor = 0;  // m, z

  /// Near the surface only, negative inside.
  double distance(const dvec3& p) const;
  /// Inside, at `depth` (m) below the surface.
  Tissue tissue(const dvec3& p) const;
  double pulp_distance(const dvec3& p) const;
  /// m, z of the chewing surface.
  double surface(double x, double y) const;
  /// m, y of the central fissure at x.
  double fissure(double x) const;
};

std::vector<std::string> tooth_types();
/// `type`: of tooth_types(). Throws Error.
CaseTooth make_tooth(const std::string& type, double age, SplitMix64& random);

/// Samples the tooth, with exact distances.
haptics::DenseTissue sample_tooth(const CaseTooth& tooth, double voxel);

}  // namespace typodont

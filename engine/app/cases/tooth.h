// A whole tooth (crown, roots, enamel, pulp), generated from published sizes (assets/cases/teeth.json) and a seed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/app/tissue/tooth_form.h"
#include "engine/base/split_mix.h"
#include "haptics/dense_tissue.h"

namespace typodont {

/// Uniform random number, 0 to 1.
double uniform(SplitMix64& random);
/// Normally distributed random number: mean 0, standard deviation 1, at most two standard deviations from the mean.
double normal(SplitMix64& random);

/// A tapered tube; its cross-section is a circle, or an ellipse if `stretch_y` is not 1.
struct TaperedTube {
  dvec3 a{0}, b{0};  // m, ends of the axis
  double radius_a = 0, radius_b = 0;
  double stretch_y = 1;
  double distance(const dvec3& p) const;
};

class ScannedTooth;

/// A generated tooth. Lengths in m. Frame as in ToothForm: origin in the neck, x mesial, y buccal, z out of the crown.
struct CaseTooth {
  std::string type;  // for example "L6": lower first molar
  std::string name;
  double age = 0;  // years; the pulp shrinks with age
  double md = 0, bl = 0, crown = 0, root = 0;
  ToothForm form;
  ToothForm blunt;                 // form without grooves; the enamel's thickness is measured from it
  double fossa = 0;                // m, depth of the lingual fossa of a front tooth; 0: none
  double furcation = 0;            // m below the neck where roots separate; 0: one root
  std::vector<TaperedTube> roots;  // each root is two tubes, one after the other; empty: the trunk is the root
  // m, height to which the enamel's edge rises above the neck, on the mesial and on the distal side
  double cej_mesial = 0, cej_distal = 0;
  double enamel = 0;                           // m, thickness of the enamel in the occlusal third
  std::vector<TaperedTube> pulp;               // the pulp as tubes: chamber, horns and canals
  double chamber_roof = 0, chamber_floor = 0;  // m, z of the chamber's roof and floor
  /// Gives surface and tissue of a scanned tooth, of which the other members are only measures. Null: parametric.
  std::shared_ptr<const ScannedTooth> scan;

  /// Signed distance to the surface, m, negative inside. Exact near the surface.
  double distance(const dvec3& p) const;
  /// Signed distance to `outer` (`form` or `blunt`) with the lingual fossa removed, m.
  double hollowed(const ToothForm& outer, const dvec3& p) const;
  /// The tissue at a point inside the tooth.
  Tissue tissue(const dvec3& p) const;
  double pulp_distance(const dvec3& p) const;
  /// Height z of the chewing surface at (x, y), m.
  double surface(double x, double y) const;
  /// Position y of the central fissure at x, m.
  double fissure(double x) const;
};

std::vector<std::string> tooth_types();
/// Name of a type, for example "lower first molar".
std::string tooth_name(const std::string& type);
/// Generates a tooth. `type`: one of tooth_types(). `curvature`: rad, angle by which each root of a molar bends to
/// distal at half its length (Schneider 1971); 0: the usual bend. Throws Error.
CaseTooth make_tooth(const std::string& type, double age, SplitMix64& random, double curvature = 0);

struct PocketGum;

/// Samples the tooth with exact distances. `voxel`: edge length, m. `gum`: gum around the tooth; may be null.
haptics::DenseTissue sample_tooth(const CaseTooth& tooth, double voxel, const PocketGum* gum = nullptr);

}  // namespace typodont

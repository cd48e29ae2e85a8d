// A block of gum around a generated tooth, with a pocket at each of six sites.
#pragma once

#include <vector>

#include "engine/app/cases/tooth.h"

namespace typodont {

inline constexpr double kFreeGum = 0.5e-3;  // m, height of the gum's margin above the neck

/// A pocket: a gap between root and gum. Frame of the tooth, m.
struct Pocket {
  dvec3 margin{0}, floor{0};  // middle of the gap at the gum's margin and at the pocket's floor
  dvec3 out{0, 1, 0};         // unit normal of the tooth's surface at the margin, horizontal
  double half_width = 0;      // m, along the gum's margin
};

struct PocketGum {
  explicit PocketGum(const CaseTooth& of) : tooth(&of) {}

  const CaseTooth* tooth;
  double sulcus = 1e-3;  // m, depth of the gap between two pockets
  std::vector<Pocket> pockets;

  /// Adds a pocket at the position x along the arch. `side`: 1 buccal, -1 lingual. `depth`: m below the margin, along
  /// the tooth's axis.
  void add_pocket(double x, double side, double depth, double half_width);
  /// Height of the gum's margin around the tooth, m.
  double margin(const dvec3& p) const;
  /// Signed distance to the gum, m, negative inside.
  double distance(const dvec3& p) const;
  dvec3 low() const;
  dvec3 high() const;
};

}  // namespace typodont

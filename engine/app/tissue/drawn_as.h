// Draws a tissue as another one, to hide a lesion (material key "looks_like").
#pragma once

#include <array>
#include <cstddef>

#include "engine/contract/tissue.h"

namespace typodont {

/// By default, each tissue is drawn as itself.
class DrawnAs {
 public:
  DrawnAs() {
    for (std::size_t i = 0; i < as_.size(); ++i) as_[i] = static_cast<Tissue>(i);
  }
  void set(Tissue tissue, Tissue as) { as_[static_cast<std::size_t>(tissue)] = as; }
  Tissue operator()(Tissue tissue) const { return as_[static_cast<std::size_t>(tissue)]; }
  /// Replaces each label by the tissue drawn in its place.
  template <class Labels>
  void apply(Labels& labels) const {
    if (*this == DrawnAs()) return;
    for (Tissue& label : labels) label = (*this)(label);
  }
  bool operator==(const DrawnAs&) const = default;

 private:
  std::array<Tissue, kTissueCount> as_{};
};

}  // namespace typodont

// Colours of the tissues for tests that draw without a material table.
#pragma once

#include "engine/render/look.h"

namespace typodont::render {

inline MaterialTable default_colors() {
  MaterialTable m{};
  const auto set = [&](Tissue t, dvec3 c) { m[static_cast<std::size_t>(t)].color = c; };
  set(Tissue::kEnamel, {0.728, 0.6815, 0.618});
  set(Tissue::kDentin, {0.72, 0.64, 0.50});
  set(Tissue::kCaries, {0.36, 0.22, 0.12});
  set(Tissue::kPulp, {0.61, 0.25, 0.22});
  set(Tissue::kCorticalBone, {0.80, 0.75, 0.65});
  set(Tissue::kCancellousBone, {0.74, 0.57, 0.46});
  set(Tissue::kGingiva, {0.648, 0.417, 0.398});
  set(Tissue::kAmalgam, {0.66, 0.67, 0.69});
  set(Tissue::kComposite, {0.76, 0.71, 0.62});
  return m;
}

}  // namespace typodont::render

// The contact method "vertex": a mesh whose vertices the head pushes away (paper S4 in docs/papers.md).
#pragma once

#include <cstddef>

#include "haptics/contact_method.h"

namespace typodont::haptics::vertex {

inline constexpr std::string_view kName = "vertex";

struct Parameters {
  double edge = 0;              // m, target edge length; 0: a sixth of the head's radius
  bool as_printed = false;      // true: uses the rules exactly as printed in paper S4 (README.md)
  std::size_t spare = 200'000;  // number of vertices that cuts may add

  double edge_for(const Tool& tool) const { return edge > 0 ? edge : tool.radius() / 6; }
};

/// Reads the parameters, and creates the method with them. Throws Error.
SharedContactMethod read(Keys& keys);

}  // namespace typodont::haptics::vertex

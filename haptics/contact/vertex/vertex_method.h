// The contact model "vertex": a triangle mesh whose vertices the head pushes away (paper S4 in docs/papers.md).
#pragma once

#include <cstddef>
#include <optional>

#include "haptics/contact_method.h"
#include "haptics/coupling/filters.h"

namespace typodont::haptics::vertex {

inline constexpr std::string_view kName = "vertex";

struct Parameters {
  double edge = 0;          // m, wanted length of mesh edges on a cut surface; 0: a sixth of the head's radius
  bool as_printed = false;  // true: uses the rules that are printed in paper S4 (README.md)
  // parameters of the force filter of paper S4, figure 5; empty: the force is not filtered
  std::optional<ForceFilterLaw> filter;
  std::size_t spare = 200'000;  // number of additional vertices for which memory is reserved; cuts may add no more

  double edge_for(const Tool& tool) const { return edge > 0 ? edge : tool.radius() / 6; }
};

/// Creates the method from its parameters in a scene file, for example {"edge_mm": 0.1, "as_printed": false, "filter":
/// {"xi_N": 0.001, "zeta_N": 0.1, "lambda_N": 3}, "spare_vertices": 200000}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::vertex

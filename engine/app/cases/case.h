// An exercise from a family, a seed and a difficulty (docs/cases.md).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "engine/app/cases/tooth.h"

namespace typodont {

struct CaseFamily {
  std::string name, title;
  std::vector<std::string> teeth, parameters;
};
std::vector<CaseFamily> case_families();

struct CaseRequest {
  std::string family;
  std::uint64_t seed = 1;
  double difficulty = 0.5;  // 0..1
  std::string tooth;        // one of the family's; empty: by the seed
};

struct Case {
  CaseTooth tooth;
  std::map<std::string, double> parameters;  // mm, °, years
  haptics::DenseTissue tissue;
  std::string scene;                // JSON; its volume is `volume`
  double expert = 0, careless = 0;  // points of the exact plan, and of the same plan by a careless hand
};

/// Equal requests give equal bits. `out`: scene file; the volume is beside it, with the ending .vdb. Writes both.
/// Throws Error for a wrong request, and RunFailure for a seed without a valid case.
Case make_case(const CaseRequest& request, const std::filesystem::path& out);

}  // namespace typodont

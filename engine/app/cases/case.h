// Generates an exercise from a case family, a seed and a difficulty (docs/cases.md).
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/cases/tooth.h"
#include "engine/base/json.h"
#include "engine/session/task.h"

namespace typodont {

struct CaseFamily {
  std::string name;
  session::TaskText title;
  std::vector<std::string> teeth, parameters;
  std::map<std::string, double> weights;  // weight of each item of the score
};
std::vector<CaseFamily> case_families();

struct CaseIdentity {
  std::string family;
  std::uint64_t seed = 1;
  double difficulty = 0.5;  // 0: easiest, 1: most difficult
};
// The value of the key "case" in scenes, reports and cached scores. read_case() throws Error.
CaseIdentity read_case(const Json& json);
nlohmann::ordered_json json_of(const CaseIdentity& made);
/// The key "case" of a scene; empty if the scene is no generated case. Throws Error.
std::optional<CaseIdentity> case_in(const Json& scene);

struct CaseRequest : CaseIdentity {
  std::string tooth;           // tooth of the case family; empty: the seed selects one
  std::filesystem::path scan;  // scene with a scanned tooth of the type `tooth`; empty: a parametric tooth
};

struct Case {
  CaseTooth tooth;
  std::map<std::string, double> parameters;  // measures of the tooth and the lesion by name: mm, degrees or years
  std::string scene;                         // JSON text of the scene; its volume is `volume`
  double expert = 0, careless = 0;  // score of the planned strokes if they are cut exactly; if the hand is careless
};

/// Name and type of a tooth; of a parametric tooth also the patient's age.
std::string in_words(const CaseTooth& tooth);

/// Generates a case. Writes the scene file `out`, and beside it the volume (.vdb). Equal requests give bit-identical
/// files. Throws Error for an invalid request, RunFailure if this seed gives no valid case.
Case make_case(const CaseRequest& request, const std::filesystem::path& out);

}  // namespace typodont

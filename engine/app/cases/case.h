// Generates an exercise from a case family, a seed and a difficulty (docs/cases.md).
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/cases/tooth.h"
#include "engine/app/scene.h"
#include "engine/base/json.h"
#include "engine/session/score.h"
#include "engine/session/task.h"

namespace typodont {

struct CaseFamily {
  std::string name;
  session::TaskText title;
  std::vector<std::string> teeth, parameters;
  std::map<std::string, double> weights;  // weight of each item of the score
};
std::vector<CaseFamily> case_families();

nlohmann::ordered_json json_of(const CaseIdentity& made);
/// The key "case" of a scene; empty if the scene is no generated case. Throws Error.
std::optional<CaseIdentity> case_in(const Json& scene);

struct CaseRequest : CaseIdentity {
  std::string tooth;           // tooth of the case family; empty: the seed selects one
  std::filesystem::path scan;  // scene with a scanned tooth of the type `tooth`; empty: a parametric tooth
};

/// Errors of a simulated hand that otherwise follows the planned strokes exactly, in the cavity's axes: x mesial, z out
/// of the opening.
struct HandErrors {
  dvec3 shift{0};                        // m, displacement of all strokes
  glm::dvec2 tilt{0};                    // rad, rotation of the shank about x and y, around the head's centre
  double spread = 0;                     // m, standard deviation of the end of each stroke on each axis
  std::uint64_t seed = 1;                // of the spread
  double force_mean = 0, force_max = 0;  // N, stated to the score; strokes are cut without forces
};

struct Case {
  CaseTooth tooth;
  std::map<std::string, double> parameters;  // measures of the tooth and the lesion by name: mm, degrees or years
  std::string scene;                         // JSON text of the scene; its volume is `volume`
  double expert = 0, careless = 0;           // points of the planned strokes: cut exactly; cut by a careless hand
  std::vector<session::Score> hands;         // scores of the requested hands
};

/// Name and type of a tooth; of a parametric tooth also the patient's age.
std::string in_words(const CaseTooth& tooth);

/// Generates a case. Writes the scene file `out`, and beside it the volume (.vdb). Equal requests give bit-identical
/// files. `hands`: simulated hands to score; only in families with an ideal shape. Throws Error for an invalid request,
/// RunFailure if this seed gives no valid case.
Case make_case(const CaseRequest& request, const std::filesystem::path& out, const std::vector<HandErrors>& hands = {});

}  // namespace typodont

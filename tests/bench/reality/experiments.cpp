#include "tests/bench/reality/experiments.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::bench {

namespace {

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) {
    const std::size_t first = part.find_first_not_of(' ');
    parts.push_back(first == std::string::npos ? "" : part.substr(first));
  }
  return parts;
}

/// Cells may be quoted.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

/// In the table's units.
double measure(const Experiment& e, const Conditions& conditions, bool brief) {
  if (e.rig == "motor") {
    const MotorCurve curve = brake(conditions);
    if (e.quantity == "stall_torque") return curve.stall_torque / kMillimetre;
    if (e.quantity == "max_power") return curve.max_power;
    if (e.quantity == "free_speed") return curve.free_speed / kKrpm;
    if (e.quantity == "power_at") return 100 * curve.power_at;
  }
  if (e.rig == "screw") return insert(conditions, brief ? 0.2 : 30) / kMillimetre;
  const auto longest = [&] { return e.rig == "face" ? 10.0 : e.rig == "tooth" ? 60.0 : e.rig == "slot" ? 90.0 : 30.0; };
  const Measured m = run_rig(e.rig, conditions, brief ? 0.2 : longest() * (conditions.contains("cuts") ? 40 : 1));
  if (e.quantity == "rate") return m.rate / kCubicMillimetre;
  if (e.quantity == "feed") return m.feed / kMillimetre;
  if (e.quantity == "force") return m.force;
  if (e.quantity == "torque") return m.torque / kMillimetre;
  if (e.quantity == "energy") return m.energy / kJoulePerCubicMillimetre;
  if (e.quantity == "speed") return m.speed / kKrpm;
  if (e.quantity == "speed_percent") return 100 * m.speed / m.free_speed;
  if (e.quantity == "speed_drop") return 100 * (1 - m.speed / m.free_speed);
  if (e.quantity == "pulp") return m.pulp;
  if (e.quantity == "force_ratio") return m.force_ratio;
  if (e.quantity == "fall") return 100 * m.fall;
  if (e.quantity == "pressure") return m.force / (kPi * m.radius * m.radius) * 1e-6;
  if (e.quantity == "time_9.5mm") return m.feed > 0 ? 9.5 * kMillimetre / m.feed : 0;
  throw Error("experiments.csv", e.id, e.quantity, "a known quantity");
}

/// Two runs if a condition is "a>b": the ratio second / first, or the exponent of that condition.
double compare(const Experiment& e, Conditions conditions, bool brief) {
  const bool exponent = conditions.contains("compare");
  conditions.erase("compare");
  for (auto& [key, text] : conditions) {
    const std::vector<std::string> ends = split(text, '>');
    if (ends.size() != 2) continue;
    text = ends[0];
    const double before = measure(e, conditions, brief);
    text = ends[1];
    const double after = measure(e, conditions, brief);
    if (!(before > 0)) return 0;
    return exponent ? std::log(after / before) / std::log(std::stod(ends[1]) / std::stod(ends[0])) : after / before;
  }
  return measure(e, conditions, brief);
}

/// Computes the result for all combinations of the unknown conditions, until visit(result) returns true. Returns
/// whether it did.
template <class Visit>
bool scan(const Experiment& e, const Conditions& conditions, bool brief, const Visit& visit) {
  for (const auto& [key, text] : conditions) {
    const std::vector<std::string> values = split(text, '|');
    if (values.size() < 2) continue;
    Conditions one = conditions;
    return std::ranges::any_of(values, [&](const std::string& value) {
      one[key] = value;
      return scan(e, one, brief, visit);
    });
  }
  return visit(compare(e, conditions, brief));
}

}  // namespace

std::vector<Experiment> experiments() {
  const std::filesystem::path file = TYPODONT_REALITY "/experiments.csv";
  std::ifstream in(file);
  if (!in) throw Error(file.string(), "", "no file", "a table of experiments");
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> head = cells_of(line);
  std::vector<Experiment> all;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = cells_of(line);
    const auto cell = [&](const char* name) {
      return cells.at(static_cast<std::size_t>(std::find(head.begin(), head.end(), name) - head.begin()));
    };
    if (cell("rig").empty()) continue;
    Experiment e{cell("id"), cell("quantity"), cell("rig"), cell("role"), {}};
    if (!cell("low").empty()) e.low = std::stod(cell("low"));
    if (!cell("high").empty()) e.high = std::stod(cell("high"));
    for (const std::string& condition : split(cell("conditions"), ';')) {
      const std::size_t equals = condition.find('=');
      e.conditions[condition.substr(0, equals)] = condition.substr(equals + 1);
    }
    all.push_back(std::move(e));
  }
  return all;
}

void Band::add(double value) {
  low = std::min(low, value), high = std::max(high, value);
}

Band simulate(const Experiment& experiment, bool brief) {
  Band band;
  scan(experiment, experiment.conditions, brief, [&](double value) {
    band.add(value);
    return brief;
  });
  return band;
}

bool agrees(const Experiment& experiment) {
  Band band;
  return scan(experiment, experiment.conditions, false, [&](double value) {
    band.add(value);
    return band.high >= experiment.low && band.low <= experiment.high;
  });
}

}  // namespace typodont::bench

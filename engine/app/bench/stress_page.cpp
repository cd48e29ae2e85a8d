#include "engine/app/bench/stress_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "engine/app/bench/page_text.h"
#include "engine/base/error.h"
#include "engine/base/file_kind.h"
#include "engine/base/json.h"
#include "engine/base/markup.h"

namespace typodont {

namespace {

struct Name {
  std::string campaign, model, measure;
};
/// Splits the name "campaign, model: measure" of a row (a campaign is a series of stress tests). The parts are empty if
/// the name has another form.
Name name_of(const BenchRow& row) {
  const std::size_t comma = row.name.find(", "), colon = row.name.find(": ");
  if (comma == std::string::npos || colon == std::string::npos || colon < comma) return {};
  return {row.name.substr(0, comma), row.name.substr(comma + 2, colon - comma - 2), row.name.substr(colon + 2)};
}

/// Measures of a stress test that count as failures of a contact model. If the value of one of these measures exceeds
/// its limit, the model has failed (Survival::kFell). If any other measure exceeds its limit, the model is only flawed
/// (kFlawed).
constexpr std::array<std::string_view, 5> kFalls{"not finite", "beyond the limit", "came through", "holes", "escaped"};

struct Campaign {
  std::string_view name, what;
};
constexpr Campaign kCampaigns[] = {
    {"hostile hand",
     "Simulated hands move at random with up to 0.2 m/s and 20 m/s² and rotate in all directions. Half of these hands "
     "drill. The servo limits the force to 8 N"},
    {"nonsense",
     "The simulated hands move as in the test \"hostile hand\", but give invalid input in one tick of fifty. The "
     "invalid input has positions that are NaN, infinite or far away, jumps of the hand, a clock that jumps back or "
     "forward by 3 s, and undone strokes"},
    {"carver stalls",
     "A simulated hand slides, drills and taps while the carver thread stalls for 50 ms to 3 s. The value \"step\" is "
     "the largest force step with stalls minus the largest force step of the same hand without a stall"},
    {"uneven clock",
     "The simulated hands move as in the test \"hostile hand\". The tick periods vary by ±20 % and ±50 %, and one "
     "tick of a hundred is five times as long"},
    {"200 N",
     "A simulated hand of 1 kg presses a tool head of 20 mm on a ball of bone with 200 N while the head slides and "
     "reams. The contact stiffness is 60 N/mm"},
    {"fast probe",
     "The tip of an explorer (a probe of 0.25 mm) slides over the edges of a box, a groove and the dental arch with "
     "30, 60 and "
     "120 mm/s, at a depth of half its radius"},
    {"thin wall",
     "A ball of 1.2 mm moves through a sheet of 0.3 mm with 1 mm per tick. A hand that has passed through the sheet "
     "escapes if no force pushes it back"}};

/// Known reason why a contact model fails in a campaign (series of stress tests). The page prints the reason only if
/// the model failed.
struct Cause {
  std::string_view campaign, model, why;
};
constexpr Cause kCauses[] = {
    {"fast probe", "offset",
     "In the tests with a fast probe, the model `offset` generates energy only on the dental arch, with forces of 0.06 "
     "N, because a scripted hand changes its direction at the fissures faster than the passivity controller predicts"},
    {"fast probe", "implant",
     "In the tests with a fast probe, the model `implant` generates energy only on the dental arch, with forces of "
     "0.06 N, because a scripted hand changes its direction at the fissures faster than the passivity controller "
     "predicts"},
    {"thin wall", "voxel_penalty",
     "The model `voxel_penalty` has no proxy (a pose of the tool outside the tissue), so nothing stops a hand that "
     "passes through the wall between two ticks"},
    {"fast probe", "voxel_penalty",
     "The springs of `voxel_penalty` are weaker if fewer than ten sample points have contact, and a tip as small as a "
     "voxel has few sample points"},
    {"carver stalls", "voxel_penalty",
     "The model `voxel_penalty` has no tissue outside its patch, and no plane of a last contact that could stop the "
     "hand there"},
    {"fast probe", "packing",
     "The gaps between 10,000 spheres are as wide as the tip of the explorer (a probe), so the tip falls into the "
     "gaps. For explorers, use more spheres or another contact model"}};

template <class T, class Member>
std::vector<std::string> distinct(const std::vector<T>& all, Member member) {
  std::vector<std::string> names;
  for (const T& t : all)
    if (std::ranges::find(names, t.*member) == names.end()) names.push_back(t.*member);
  return names;
}

const SurvivalCell* cell_of(const std::vector<SurvivalCell>& cells, const std::string& campaign,
                            const std::string& model) {
  const auto at =
      std::ranges::find_if(cells, [&](const SurvivalCell& c) { return c.campaign == campaign && c.model == model; });
  return at == cells.end() ? nullptr : &*at;
}

std::string map_of(const std::vector<SurvivalCell>& cells) {
  constexpr int kLeft = 130, kTop = 40, kWidth = 170, kHeight = 44;
  const std::vector<std::string> campaigns = distinct(cells, &SurvivalCell::campaign),
                                 models = distinct(cells, &SurvivalCell::model);
  const int width = kLeft + kWidth * static_cast<int>(campaigns.size()) + 10,
            height = kTop + kHeight * static_cast<int>(models.size()) + 10;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" font-size=\"13\"><rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      width, height);
  constexpr std::array kColors{"#d5ead6", "#fbe3b3", "#f3c2bc"};
  constexpr std::array kWords{"survives", "flawed", "falls"};
  for (std::size_t c = 0; c < campaigns.size(); ++c)
    svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-weight=\"bold\">{}</text>\n",
                       kLeft + kWidth * static_cast<int>(c) + kWidth / 2, kTop - 12, escaped(campaigns[c]));
  for (std::size_t m = 0; m < models.size(); ++m) {
    const int y = kTop + kHeight * static_cast<int>(m);
    svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>\n", kLeft - 8, y + kHeight / 2 + 5,
                       escaped(models[m]));
    for (std::size_t c = 0; c < campaigns.size(); ++c) {
      const SurvivalCell* const cell = cell_of(cells, campaigns[c], models[m]);
      if (!cell) continue;
      const int x = kLeft + kWidth * static_cast<int>(c), middle = x + kWidth / 2;
      const auto kind = static_cast<std::size_t>(cell->survival);
      svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>", x + 1, y + 1, kWidth - 2,
                         kHeight - 2, kColors[kind]);
      svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", middle,
                         y + (cell->worst.empty() ? 27 : 19), kWords[kind]);
      if (!cell->worst.empty())
        svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\">{}</text>", middle, y + 35,
                           escaped(cell->worst));
      svg += "\n";
    }
  }
  return svg + "</svg>\n";
}

}  // namespace

std::vector<SurvivalCell> survival_of(const std::vector<BenchRow>& rows) {
  std::vector<SurvivalCell> cells;
  std::vector<double> worst;  // for each cell of the map: largest ratio of a measured value to its limit
  for (const BenchRow& row : rows) {
    const Name name = name_of(row);
    if (name.model.empty() || !(row.ratio >= 0)) continue;
    auto at = std::ranges::find_if(
        cells, [&](const SurvivalCell& c) { return c.campaign == name.campaign && c.model == name.model; });
    if (at == cells.end()) {
      cells.push_back({name.campaign, name.model, Survival::kSurvived, {}});
      worst.push_back(1);
      at = cells.end() - 1;
    }
    if (row.ratio <= 1) continue;
    const bool falls = std::ranges::find(kFalls, name.measure) != kFalls.end();
    const Survival survival = falls ? Survival::kFell : Survival::kFlawed;
    double& most = worst[static_cast<std::size_t>(at - cells.begin())];
    // Keeps the worse of two results of a contact model. kFell is worse than kFlawed. If both results are kFell, or
    // both are kFlawed, the one with the larger ratio of value to limit is worse.
    if (survival < at->survival || (survival == at->survival && row.ratio < most)) continue;
    at->survival = survival, most = row.ratio;
    at->worst =
        fmt::format("{}: {:.3g} {}", name.measure, row.error, row.error_unit.substr(0, row.error_unit.find(' ')));
  }
  return cells;
}

void write_stress_page(const std::filesystem::path& file, const std::vector<BenchRow>& rows,
                       const std::string& machine) {
  const std::filesystem::path folder = std::filesystem::path(file).replace_extension();
  std::filesystem::create_directories(folder);
  const std::vector<SurvivalCell> cells = survival_of(rows);
  write_file_atomically(folder / "map.svg", map_of(cells), FileKind::kDrawing);

  std::string page = fmt::format(
      "# What each contact model survives\n\n"
      "The command `./run bench stress` (`typodont bench stress --out docs/stress/rows.csv --page docs/stress.md`) "
      "created this page. All numbers on this page come from [rows.csv]({0}/rows.csv). The tests run a short "
      "version of this benchmark.\n\n"
      "**Measured on**: {1}.\n\n"
      "![Map of the results, contact models in rows and campaigns (series of tests) in columns]({0}/map.svg)\n\n"
      "- The result **survives** means that every measured value is within its limit.\n"
      "- The result **flawed** means that the force is finite, is within its limit, and stops the hand, but the model "
      "has a fault. A flawed model generates energy (more than 1 nJ), has force steps (0.25 N per tick more than "
      "without the "
      "disturbance), or has a large error.\n"
      "- The result **falls** means that the force is not finite or exceeds its limit, or that the hand passes through "
      "the tissue or feels no force in the tissue.\n\n## The campaigns\n\n",
      folder.filename().string(), machine);
  for (const Campaign& campaign : kCampaigns) page += fmt::format("- **{}**. {}.\n", campaign.name, campaign.what);
  std::string causes;
  for (const Cause& cause : kCauses) {
    const SurvivalCell* const cell = cell_of(cells, std::string(cause.campaign), std::string(cause.model));
    if (cell && cell->survival != Survival::kSurvived)
      causes += fmt::format("- `{}`, {}. {}.\n", cause.model, cause.campaign, cause.why);
  }
  if (!causes.empty()) page += "\n## Why some do not survive\n\n" + causes;
  page += "\n## Figures\n\n| campaign | measure | limit |";
  const std::vector<std::string> models = distinct(cells, &SurvivalCell::model);
  for (const std::string& model : models) page += fmt::format(" `{}` |", model);
  page += "\n|---|---|---|";
  for (std::size_t i = 0; i < models.size(); ++i) page += "---|";
  page += "\n";
  std::vector<std::string> told;
  for (const BenchRow& row : rows) {
    const Name name = name_of(row);
    const std::string key = name.campaign + ": " + name.measure;
    if (name.model.empty() || std::ranges::find(told, key) != told.end()) continue;
    told.push_back(key);
    const std::size_t limit = row.baseline.rfind(", ");
    const std::string passes = limit != std::string::npos      ? row.baseline.substr(limit + 2)
                               : row.baseline == "none passes" ? "0"
                                                               : "";
    page += fmt::format("| {} | {}, {} | {} |", name.campaign, name.measure, row.error_unit, passes);
    for (const std::string& model : models) {
      const auto at = std::ranges::find_if(rows, [&](const BenchRow& other) {
        return other.name == fmt::format("{}, {}: {}", name.campaign, model, name.measure);
      });
      if (at == rows.end()) {
        page += " – |";
      } else {
        page += at->ratio <= 1 ? fmt::format(" {:.3g} |", at->error) : fmt::format(" **{:.3g}** |", at->error);
      }
    }
    page += "\n";
  }
  write_page(file, page);
}

}  // namespace typodont

// A scripted hand makes known errors at known times; the report must name their strokes, and no others.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "engine/app/recording.h"
#include "engine/app/recording/resume.h"
#include "engine/app/review/session_report.h"
#include "engine/app/scene.h"
#include "engine/app/stepped.h"
#include "haptics/scripted_hand.h"
#include "tests/support/campaign.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

/// A block of soft dentin with pulp below, a pocket with round corners as the ideal, and a mirrored block beside it.
const char* const kBlock = R"({"tissue": {"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -2], "size_mm": [8, 5, 4]}}},
    {"tissue": "pulp", "solid": {"box": {"center_mm": [0, 0, -2.4], "size_mm": [1.2, 1.2, 1]}}}]}, "tool": "round_012"})";
const char* const kScene = R"({"tissue": {"volume": "block.vdb"},
  "tools": [{"shape": "cylinder", "diameter_mm": 1.0, "length_mm": 3}], "spindle_krpm": 300,
  "materials": {"dentin": {"specific_energy_J_per_mm3": 0.8}, "pulp": {"specific_energy_J_per_mm3": 0.03}},
  "tooth": {"mesial": [1, 0, 0], "buccal": [0, 1, 0]},
  "surroundings": {"neighbours": [{"contact_mm": [4, 0, -0.5]}]},
  "task": {"goal": "a pocket", "rules": [{"name": "force_max_N", "target": 1.5, "tolerance": 1, "weight": 5}], "ideal": {"remove": [
      {"box": {"center_mm": [0, 0, 0], "size_mm": [5, 1, 2]}}, {"box": {"center_mm": [0, 0, 0], "size_mm": [4, 2, 2]}},
      {"cylinder": {"center_mm": [2, 0.5, 0], "radius_mm": 0.5, "height_mm": 2}},
      {"cylinder": {"center_mm": [-2, 0.5, 0], "radius_mm": 0.5, "height_mm": 2}},
      {"cylinder": {"center_mm": [2, -0.5, 0], "radius_mm": 0.5, "height_mm": 2}},
      {"cylinder": {"center_mm": [-2, -0.5, 0], "radius_mm": 0.5, "height_mm": 2}}]}}})";

struct Injected {
  std::string item;
  double from = 0, to = 0;  // s, at the wrong place
  dvec3 p_mm{0};            // of what is left
};

/// Positions of the head's end in mm, at a steady pace.
class Path {
 public:
  void to(const dvec3& end_mm, double pace = 4, double pedal = 1) {
    const double z = end_mm.z + 1.5;  // the head's centre
    const dvec3 p_mm(end_mm.x, end_mm.y, z);
    if (!path_.rows.empty()) t_ += std::max(glm::length(p_mm - path_.rows.back().X_WT.p * 1e3) / pace, 1e-3);
    path_.rows.push_back({t_, {p_mm * 1e-3, dquat(1, 0, 0, 0)}, pedal, dvec3(0), 0});
  }
  void wait(double seconds, double pedal) {
    t_ += seconds;
    haptics::HandPath::Row row = path_.rows.back();
    row.t = t_, row.pedal = pedal;
    path_.rows.push_back(row);
  }
  dvec3 end_mm() const { return path_.rows.back().X_WT.p * 1e3 - dvec3(0, 0, 1.5); }
  double now() const { return t_; }
  haptics::HandPath take() { return std::move(path_); }

 private:
  double t_ = 0;  // s
  haptics::HandPath path_;
};

class Defects : public testing::Test {
 protected:
  Defects() {
    folder.write("block.json", kBlock);
    load_tissue(read_scene(folder.path() / "block.json")).save(folder.path() / "block.vdb");
    folder.write("scene.json", kScene);
  }

  /// Cuts the pocket in layers, with errors on the way along its floor; returns them.
  std::vector<Injected> drill(std::uint64_t seed, const std::string& out) {
    std::mt19937_64 random(seed);
    const auto number = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
    Path path;
    std::vector<Injected> errors;
    // Goes to a wrong place, stays there and comes back; the drill's pedal as stated.
    const auto err = [&](const std::string& item, const dvec3& wrong_mm, double pedal = 1) {
      const dvec3 back_mm = path.end_mm();
      path.wait(0.01, pedal);
      path.wait(0.9, pedal);
      path.to(wrong_mm, pedal > 0 ? 2 : 15, pedal);
      const double there = path.now();
      path.wait(0.3, pedal);
      errors.push_back({item, there, path.now()});
      path.to(back_mm, pedal > 0 ? 4 : 15, pedal);
      path.wait(0.9, pedal);
    };
    path.to({-2, -0.5, 2});
    for (const double z : {-0.5, -1.0}) {
      path.to({-2, -0.5, z}, 2);
      for (const double y : {-0.5, 0.5}) {
        const double begin = y < 0 ? -2 : 2;
        path.to({begin, y, z}, 2);
        path.wait(0.3, 1);
        if (z == -1.0) {
          const double x = number(-1.3, 1.3);
          const int kind = static_cast<int>(random() % 4);
          if (kind < 3) path.to({x, y, z}, 2);
          if (kind == 0) {  // into the floor
            err("over_cut_depth_mm", {x, y, z - number(0.4, 0.6)});
          } else if (kind == 1) {  // into the wall
            err("over_cut_depth_mm", {x, y * (1 + 2 * number(0.4, 0.6)), z});
          } else if (kind == 2) {  // presses, the drill at rest
            err("force_max_N", {x, y, z - 5}, 0);
          } else {  // lifts for 1.6 mm
            const double dir = begin < 0 ? 1 : -1, from = -dir * number(0, 1.3);
            path.to({from, y, z}, 2);
            path.to({from, y, z + 0.6});
            path.to({from + 1.6 * dir, y, z + 0.6});
            path.to({from + 1.6 * dir, y, z}, 2);
            errors.push_back({"under_cut_depth_mm", 0, 0, {from + 0.8 * dir, y, z}});
          }
        }
        path.to({-begin, y, z}, 2);
        path.wait(0.3, 1);
      }
    }
    path.to({0, 0, -1});
    if (random() % 2) {  // opens the pulp
      err("pulp_removed_mm3", {0, 0, -2.2});
      errors.push_back(errors.back());
      errors.back().item = "over_cut_depth_mm";
    }
    path.to({0, 0, 2}, 8);
    if (random() % 2) {  // an error that is undone
      path.to({-3.3, 0, 2}, 8);
      path.to({-3.3, 0, -0.6}, 2);
      path.to({-3.3, 0, 2}, 8);
      path.wait(1, 1);
      undo_at_ = path.now();
      path.wait(0.5, 1);
    }
    if (random() % 2) {  // touches the neighbour
      path.to({6, 0, 3}, 8);
      err("neighbour_removed_mm3", {6, 0, -0.3});
    }
    path.wait(0.5, 1);
    record(path.take(), out);
    return errors;
  }

  void record(haptics::HandPath path, const std::string& out) {
    const Scene scene = read_scene(folder.path() / "scene.json");
    const auto hand = haptics::make_scripted_hand(std::move(path), 1000, false);
    SteppedSession session(scene, load_tissue(scene), hand->info());
    session.omit_times();
    SessionRecorder recorder(out, scene, hand->info(), session.carver().volume(), session.event_logs());
    while (session.advance(*hand)) {
      if (undo_at_ && to_seconds(session.last().t) >= *undo_at_) {
        EXPECT_TRUE(session.edit(false));
        undo_at_.reset();
      }
      recorder.turn();
    }
    recorder.finish(session.carver().volume());
  }

  std::optional<double> undo_at_;  // s
  test::ProgramFolder folder{""};  // no program runs
};

TEST_F(Defects, NameTheStrokesOfInjectedErrorsWithinAFifthOfASecondAndNoOthers) {
  constexpr double kSlack = 0.2;  // s
  int injected = 0, found = 0, named = 0, right = 0;
  const std::uint64_t seed = test::campaign_seed(1);
  for (std::uint64_t k = seed; k < seed + static_cast<std::uint64_t>(test::campaign(6)); ++k) {
    const std::string file = folder / "session.h5";
    const std::vector<Injected> errors = drill(k, file);
    const session::SessionReader session{std::filesystem::path(file)};
    const std::vector<session::Defect> defects = report_of(session).defects;
    const auto leaves = [&](const session::Defect& defect, const Injected& error) {
      return defect.item == error.item && defect.left && glm::length(defect.p_W * 1e3 - error.p_mm) < 1;
    };
    const auto made = [&](const session::Defect& defect, const session::DefectStroke& stroke, const Injected& error) {
      return defect.item == error.item && stroke.at.t > error.from - kSlack && stroke.at.t < error.to + kSlack;
    };
    for (const session::Defect& defect : defects) {
      for (const session::DefectStroke& stroke : defect.strokes) {
        ++named;
        const bool is = std::ranges::any_of(
            errors, [&](const Injected& error) { return made(defect, stroke, error) || leaves(defect, error); });
        right += is;
        if (!is) fmt::print("seed {}: named {} at {:.3f} s\n", k, defect.item, stroke.at.t);
      }
    }
    for (const Injected& error : errors) {
      ++injected;
      const bool is = std::ranges::any_of(defects, [&](const session::Defect& defect) {
        return leaves(defect, error) ||
               std::ranges::any_of(defect.strokes, [&](const auto& stroke) { return made(defect, stroke, error); });
      });
      found += is;
      if (!is) fmt::print("seed {}: missing {} {:.3f} to {:.3f}\n", k, error.item, error.from, error.to);
    }
  }
  fmt::print("{} of {} errors found, {} of {} named strokes right\n", found, injected, right, named);
  EXPECT_GT(injected, 15);
  EXPECT_GE(found, 0.95 * injected);
  EXPECT_GE(right, 0.95 * named);
}

}  // namespace
}  // namespace typodont

// What a session shows beyond the tooth's surface, and how it stands by the rules: section, tissues inside, difference
// from the ideal, score so far. Made on a thread of its own from copies the carver makes for it, so that the hand never
// waits; the bricks drawn so far are kept, so that a picture may join or be looked at otherwise at any time. The thread
// starts when there is something for it: at once where somebody watches the score, else with the first look that needs
// it.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/app/field/tooth_field.h"
#include "engine/app/picture/look.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/session/explore.h"
#include "engine/session/score.h"

namespace typodont {

/// The two pictures a session may have.
enum class Eyes { kTrainee, kOwn };

class LiveViews {
 public:
  /// `tissue` is only read here; `around` outlives this. `judged`: the score so far is wanted, too.
  LiveViews(const Scene& scene, const haptics::TissueVolume& tissue, const Surroundings& around, Wiring& wiring,
            bool judged);
  /// Waits for what its thread is making.
  ~LiveViews();
  LiveViews(const LiveViews&) = delete;
  LiveViews& operator=(const LiveViews&) = delete;

  // The drawing thread's.
  /// A picture that is there from now on, or that is gone (null).
  void attach(Eyes eyes, PictureStage* stage);
  /// What the carver changed.
  void take(MeshBatch bricks);
  void look(Eyes eyes, const Look& look);
  const Look& look(Eyes eyes) const { return pictures_[index(eyes)].look; }
  /// Once a turn: gives the pictures what is there for them, a few milliseconds' worth. True when one was given
  /// something.
  bool advance();
  /// True while a look is still being made.
  bool making(Eyes eyes) const;
  /// Its thread runs.
  bool started() const { return thread_.joinable(); }

  /// Tissues the scene holds, a bit each; whether it names an ideal; the middle of the tooth.
  std::uint32_t tissues() const { return tissues_; }
  bool has_ideal() const { return scene_.task && scene_.task->ideal; }
  bool has_surroundings() const { return !around_.meshes.empty(); }
  const dvec3& middle() const { return middle_W_; }

  /// What the geometry said when it was last looked at; nothing before that. Its `hand` is the caller's to fill.
  const std::optional<session::ScoreInput>& judged() const { return judged_; }
  /// False until then, unless it cannot be looked at.
  bool score_known() const { return judged_ || !judging_; }
  /// Of the tissue as it is now, not as it was before the last cuts.
  bool score_current() const { return !judging_ || (judged_ && judged_version_ == wiring_.tissue_version); }
  /// Of a task that is to explore: feeds the ticks.
  void explore(const ServoTick& tick);
  /// What was explored, once the session is over; the ticks that no meter has seen.
  std::pair<std::optional<session::ExploreMeter>, std::vector<ServoTick>> take_explored();

 private:
  struct Wish {
    Look look;
    glm::dvec4 plane{0};
    int stage = 0;  // of one picture after the other
    bool operator==(const Wish&) const = default;
    /// Something beyond the surface's own bricks must be made for it.
    bool needs_bodies() const;
  };
  struct Body {
    render::MeshId mesh;
    std::vector<render::MeshUpdate> bricks;
  };
  struct Made {
    Eyes eyes;
    Wish wish;
    std::vector<Body> bodies;
  };
  struct Picture {
    PictureStage* stage = nullptr;
    Look look;
    Wish wish;                           // as given to the thread
    bool made = true;                    // and answered
    int stages = 0;                      // it had so far
    bool replaced = false;               // the tooth's own bricks are not shown
    std::vector<std::uint64_t> pending;  // bricks it has yet to get
  };
  static std::size_t index(Eyes eyes) { return static_cast<std::size_t>(eyes); }
  void all_again(Picture& picture);
  void show_as(Picture& picture);
  bool give(Picture& picture);
  void start();
  void run();
  std::unique_ptr<haptics::TissueVolume> copy_of_tissue();
  std::vector<Body> bodies_of(const Wish& wish, const haptics::TissueVolume& tissue) const;
  void keep(Made made);

  const Scene& scene_;
  Wiring& wiring_;
  const Surroundings& around_;
  const bool judged_at_all_;
  dvec3 origin_W_{0}, middle_W_{0};
  std::uint32_t tissues_ = 0;

  // The drawing thread's.
  std::unordered_map<std::uint64_t, render::MeshUpdate> bricks_;
  std::array<Picture, 2> pictures_;
  std::optional<session::ScoreInput> judged_;
  std::uint64_t judged_version_ = 0;  // of the tissue that it is of
  bool judging_;
  std::shared_ptr<const ToothField> ideal_;
  std::optional<session::ExploreMeter> explore_;
  std::vector<ServoTick> unexplored_;  // ticks that wait for the meter

  // Both threads', under the mutex.
  std::mutex mutex_;
  std::condition_variable wished_;
  bool stop_ = false;
  std::array<Wish, 2> wishes_;
  std::vector<Made> made_;
  std::optional<session::ScoreInput> fresh_judged_;
  std::uint64_t fresh_version_ = 0;
  std::shared_ptr<const ToothField> fresh_ideal_;
  std::optional<session::ExploreMeter> fresh_explore_;
  bool gave_up_ = false;

  std::jthread thread_;  // last: it uses the others
};

}  // namespace typodont

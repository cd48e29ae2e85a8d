// Computes section, inner tissues and difference from the target shape for a session's pictures, and the current score.
// A separate thread computes them from copies of the tissue, so that the servo never waits. All drawn mesh bricks are
// stored, so that a picture can be added or changed at any time. The thread starts with the session if the score is
// shown; otherwise it starts when a picture needs its result.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/app/picture/look.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/teaching_views.h"
#include "engine/app/scene.h"
#include "engine/app/tissue/tooth_field.h"
#include "engine/app/wiring.h"
#include "engine/session/explore.h"
#include "engine/session/score.h"

namespace typodont {

/// The two pictures that a session can have: the trainee's picture, and a picture from a free viewpoint.
enum class Eyes { kTrainee, kOwn };

class LiveViews {
 public:
  /// `tissue`: used only in the constructor. `around`: must outlive this object. `judged`: true if the score must be
  /// computed during the session.
  LiveViews(const Scene& scene, const haptics::TissueVolume& tissue, const Surroundings& around, Wiring& wiring,
            bool judged);
  /// Waits until the thread has finished its current work.
  ~LiveViews();
  LiveViews(const LiveViews&) = delete;
  LiveViews& operator=(const LiveViews&) = delete;

  // The render thread calls the next functions. attach() sets the object that draws a picture; null removes the
  // picture.
  void attach(Eyes eyes, PictureStage* stage);
  /// Receives the mesh bricks that the carver thread has changed.
  void take(MeshBatch bricks);
  void look(Eyes eyes, const Look& look);
  const Look& look(Eyes eyes) const { return pictures_[index(eyes)].look; }
  /// Passes new data to the pictures, for at most a few milliseconds. Call once per pass of the drawing loop. Returns
  /// true if a picture received data.
  bool advance();
  /// Returns true while the computing thread works for the picture of these eyes.
  bool making(Eyes eyes) const;
  /// True if the computing thread has been started.
  bool started() const { return thread_.joinable(); }

  /// tissues(): the tissues in the scene, one bit for each. middle(): m, frame W, middle of the tooth.
  std::uint32_t tissues() const { return tissues_; }
  bool can_show(render::View view) const { return typodont::can_show(scene_, view); }
  bool has_surroundings() const { return !around_.meshes.empty(); }
  const dvec3& middle() const { return middle_W_; }

  /// The result of the last evaluation of the tissue; empty before the first one. The caller must set its member
  /// `hand`.
  const std::optional<session::ScoreInput>& judged() const { return judged_; }
  /// Returns true after the first evaluation of the tissue, or if no evaluation is possible.
  bool score_known() const { return judged_ || !judging_; }
  /// True if the score includes the latest cuts.
  bool score_current() const { return !judging_ || (judged_ && judged_version_ == wiring_.tissue_version); }
  /// Adds a servo tick to the evaluation of an exploration task.
  void explore(const ServoTick& tick);
  /// The result of the exploration, and the ticks that are not yet evaluated. Call after the session.
  std::pair<std::optional<session::ExploreMeter>, std::vector<ServoTick>> take_explored();

 private:
  struct Wish {
    Look look;
    glm::dvec4 plane{0};
    /// Increases whenever another PictureStage begins to draw this picture.
    int stage = 0;
    bool operator==(const Wish&) const = default;
    /// True if the picture's Look needs more than the tooth's surface, for example inner tissues or a section.
    bool needs_bodies() const;
  };
  struct Made {
    Eyes eyes;
    Wish wish;
    std::vector<ViewBody> bodies;
  };
  struct Picture {
    PictureStage* stage = nullptr;
    Look look;
    /// The Look that the render thread requested from the computing thread.
    Wish wish;
    bool made = true;                    // true: the computing thread has answered the request `wish`
    int stages = 0;                      // number of PictureStage objects that have drawn the picture
    bool replaced = false;               // true: the picture shows another surface instead of the tooth's mesh bricks
    std::vector<std::uint64_t> pending;  // mesh bricks that were not yet passed to the picture
  };
  static std::size_t index(Eyes eyes) { return static_cast<std::size_t>(eyes); }
  void all_again(Picture& picture);
  void show_as(Picture& picture);
  bool give(Picture& picture);
  void start();
  void run();
  std::unique_ptr<haptics::TissueVolume> copy_of_tissue();
  void keep(Made made);

  const Scene& scene_;
  Wiring& wiring_;
  const Surroundings& around_;
  const bool judged_at_all_;
  dvec3 origin_W_{0}, middle_W_{0};
  dvec3 section_W_{0};  // m, middle of the caries, or of the tooth if there is none
  std::uint32_t tissues_ = 0;

  // The next members are used only by the render thread.
  std::unordered_map<std::uint64_t, render::MeshUpdate> bricks_;
  std::array<Picture, 2> pictures_;
  std::optional<session::ScoreInput> judged_;
  std::uint64_t judged_version_ = 0;  // version of the tissue for which `judged_` was computed
  bool judging_;
  std::shared_ptr<const ToothField> ideal_;
  std::optional<session::ExploreMeter> explore_;
  std::vector<ServoTick> unexplored_;  // ticks of an exploration task that are not yet evaluated

  // The next members are shared by the render thread and the computing thread, which hold the mutex while they use
  // them.
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

  std::jthread thread_;  // declared last, so that the thread is joined before the other members are destroyed
};

}  // namespace typodont

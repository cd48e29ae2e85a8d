// Only the selected exercise's picture is shown, so only that one is loaded or drawn. Main thread only.
#pragma once

#include <filesystem>
#include <memory>
#include <set>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class ScenePictures {
 public:
  ScenePictures(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}
  ~ScenePictures();
  ScenePictures(const ScenePictures&) = delete;
  ScenePictures& operator=(const ScenePictures&) = delete;

  /// For a new list of scenes.
  void forget();
  /// The GPU must not be using them.
  void destroy();
  /// NAME.png beside the scene, or from the cache, or drawn in the background. True: loaded.
  bool look();
  /// Cancels the drawing.
  void drop();

 private:
  bool take(SceneChoice& scene, const std::filesystem::path& picture);
  void begin(const std::filesystem::path& scene);

  OperatorState& s_;
  InterfaceWindow& window_;
  std::unique_ptr<Job> job_;
  std::filesystem::path drawn_;             // the scene whose picture is drawn at present
  std::filesystem::path sought_;            // the scene whose picture was sought last
  std::set<std::filesystem::path> failed_;  // scenes whose picture could not be drawn
};

}  // namespace typodont

// The pictures of the exercises. They are files beside the scenes. Missing pictures are drawn one by one while the
// start page is shown. Main thread only.
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <vector>

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

  /// Loads one picture per scene, in the order of the scenes. An empty path means that the scene has no picture.
  void load(const std::vector<std::filesystem::path>& files);
  /// Frees the GPU memory of the pictures. The GPU must not be using them.
  void destroy();
  /// Draws the next missing picture in the background, starting with that of the selected scene. Returns true if a
  /// picture was finished since the last call.
  bool look();
  /// Cancels the drawing of the scenes' pictures.
  void drop() { job_.reset(); }

 private:
  bool take(SceneChoice& scene, const std::filesystem::path& picture);
  void begin();

  OperatorState& s_;
  InterfaceWindow& window_;
  std::unique_ptr<Job> job_;
  std::filesystem::path drawn_;            // the scene whose picture is drawn at present
  std::set<std::filesystem::path> tried_;  // scenes whose picture was already drawn or failed
};

}  // namespace typodont

// The pictures of the exercises: files beside the scenes. Missing pictures are drawn one by one while the start page is
// shown. Main thread.
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

  /// Loads the pictures of the state's scenes, in the order of the scenes; an empty path means no picture.
  void load(const std::vector<std::filesystem::path>& files);
  /// Frees the pictures' GPU memory, which must not be in use.
  void destroy();
  /// Draws the next missing picture; the picture of the selected scene comes first. Returns true if a picture was
  /// finished.
  bool look();
  /// Stops drawing.
  void drop() { job_.reset(); }

 private:
  bool take(SceneChoice& scene, const std::filesystem::path& picture);
  void begin();

  OperatorState& s_;
  InterfaceWindow& window_;
  std::unique_ptr<Job> job_;
  std::filesystem::path drawn_;            // the scene whose picture is being drawn
  std::set<std::filesystem::path> tried_;  // scenes for which drawing was already tried
};

}  // namespace typodont

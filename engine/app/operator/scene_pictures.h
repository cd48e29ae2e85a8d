// The pictures of the exercises: those beside the scenes, and for the rest one after another drawn while one chooses.
// Main thread.
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

  /// Of the state's scenes, in their order; an empty path is none.
  void load(const std::vector<std::filesystem::path>& files);
  /// Their memory on the GPU, which must not be drawing them.
  void destroy();
  /// Draws the next one that is missing, the chosen scene's first. True when one has come.
  bool look();
  /// Stops drawing.
  void drop() { job_.reset(); }

 private:
  bool take(SceneChoice& scene, const std::filesystem::path& picture);
  void begin();

  OperatorState& s_;
  InterfaceWindow& window_;
  std::unique_ptr<Job> job_;
  std::filesystem::path drawn_;            // the scene that is being drawn
  std::set<std::filesystem::path> tried_;  // scenes that had their turn
};

}  // namespace typodont

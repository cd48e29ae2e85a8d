// The pictures of the exercises. The start page shows only the picture of the selected exercise, so only this picture
// is loaded, or drawn if there is none. Main thread only.
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

  /// Forgets the loaded pictures, because the list of scenes is new.
  void forget();
  /// Frees the GPU memory of the pictures. The GPU must not be using them.
  void destroy();
  /// Loads the picture of the selected scene: NAME.png beside the scene, or a picture from the cache. If there is none,
  /// draws it in the background, one picture at a time. Returns true if a picture was loaded.
  bool look();
  /// Cancels the drawing of a picture.
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

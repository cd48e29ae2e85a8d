// Lists of exercises, hands (devices) and pictures, and the user's selection, stored between runs. Main thread only.
#pragma once

#include <filesystem>
#include <string>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/scene_pictures.h"
#include "engine/app/operator/state.h"
#include "haptics/devices.h"

namespace typodont {

class Choices {
 public:
  /// Restores the selection of the last run.
  Choices(OperatorState& s, InterfaceWindow& w);

  /// Changes the language, unless there is no font for it.
  void set_language(session::Language language);
  /// Searches again for scenes, hands and display rigs. The user's selection is kept.
  void rescan();
  void choose_scene(const std::filesystem::path& file);
  void choose_tutorial();
  void remember() const;

  /// Searches for input devices while the user selects a hand. True: the connected devices have changed.
  bool look_at_devices();
  ScenePictures& pictures() { return pictures_; }

 private:
  void choose_hand(const std::string& address);

  OperatorState& s_;
  InterfaceWindow& window_;
  ScenePictures pictures_;
  haptics::DeviceWatch plugged_;
  Nanos plugged_looked_ = 0;
};

}  // namespace typodont

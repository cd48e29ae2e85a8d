// What there is to choose from, and what is chosen: exercises, hands, pictures; kept from one day to the next. Main
// thread.
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
  /// As it was left last time.
  Choices(OperatorState& s, InterfaceWindow& w);

  /// The pages in another language, where the computer can write it.
  void set_language(session::Language language);
  /// Looks for scenes, hands and rigs anew. What is chosen stays where it was.
  void rescan();
  void choose_scene(const std::filesystem::path& file);
  void choose_tutorial();
  void remember() const;

  /// What is plugged in or out while hands are chosen. True when the list is another.
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

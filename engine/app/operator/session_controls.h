// The controls below the picture of a session: recording, undo, what the picture shows.
#pragma once

#include <string>
#include <vector>

#include "engine/app/operator/widgets.h"

namespace typodont {

/// A row of buttons, which continues on the next line if the window is too narrow.
class Flow {
 public:
  struct Item {
    std::string label;
    bool on = false, enabled = true;
    bool lead = false;  // true: a label, not a button
  };
  explicit Flow(std::vector<Item> items) : items_(std::move(items)) {}

  int lines(float width) const;
  /// Index of the pressed button; −1: none.
  int draw(float width) const;

 private:
  static void place(const Item& item, float width, float& x, int& line);
  std::vector<Item> items_;
};

/// Measures and draws the session's controls in one frame.
class SessionControls {
 public:
  SessionControls(OperatorState& s, InterfaceWindow& w, float width);

  float height() const;
  void draw();
  /// True if there is a picture, so that the controls have an effect.
  bool possible() const;

 private:
  float first_line() const;

  void draw_clock();
  std::string end_label() const;

  std::vector<Flow::Item> session_items() const;
  void act(int pressed);

  static constexpr std::array kViews = {render::View::kLook, render::View::kSection, render::View::kXray,
                                        render::View::kDifference, render::View::kTemperature};
  std::vector<Flow::Item> view_items() const;
  void look(int pressed);
  bool can_see(render::View view) const;
  void see(render::View view);

  void draw_plane();

  struct Shown {
    std::string name;
    Tissue tissue = Tissue::kAir;  // tissue to show or hide; used only if `flag` is null
    bool Look::*flag = nullptr;
  };
  std::vector<Shown> shown() const;
  std::vector<Flow::Item> shown_items() const;
  void show(int pressed);

  void keys();

  OperatorState& s_;
  InterfaceWindow& w_;
  float width_;
  Flow session_, views_, shown_;
};

}  // namespace typodont

// The controls below the picture of a session: recording, undo, what the picture shows.
#pragma once

#include <functional>
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
    bool key = false;                // true: the button's key was pressed in this frame
    std::function<void()> act = {};  // empty: a label, not a button
  };
  explicit Flow(std::vector<Item> items) : items_(std::move(items)) {}

  int lines(float width) const;
  /// Draws the row, and acts for pressed buttons and keys.
  void draw(float width) const;

 private:
  static void place(const Item& item, float width, float& x, int& line);
  std::vector<Item> items_;
};

/// Measures and draws the session's controls in one frame, and handles their keys.
class SessionControls {
 public:
  SessionControls(OperatorState& s, InterfaceWindow& w, float width);

  float height() const;
  void draw();
  /// True if there is a picture, so that the controls have an effect.
  bool possible() const;

 private:
  void draw_clock();
  void draw_plane();
  std::vector<Flow::Item> session_items();
  std::vector<Flow::Item> view_items();
  std::vector<Flow::Item> shown_items();

  OperatorState& s_;
  InterfaceWindow& w_;
  float width_;
  Flow session_, views_, shown_;
};

}  // namespace typodont

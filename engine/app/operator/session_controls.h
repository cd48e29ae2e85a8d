// Below the picture of a session: recording, undo, content of the picture.
#pragma once

#include <string>
#include <vector>

#include "engine/app/operator/widgets.h"

namespace typodont {

/// Buttons in a row that may wrap.
class Flow {
 public:
  struct Item {
    std::string label;
    bool on = false, enabled = true;
    bool lead = false;  // a label, no button
  };
  explicit Flow(std::vector<Item> items) : items_(std::move(items)) {}

  int lines(float width) const;
  /// Index of the pressed button; −1: none.
  int draw(float width) const;

 private:
  static void place(const Item& item, float width, float& x, int& line);
  std::vector<Item> items_;
};

/// For one frame.
class SessionControls {
 public:
  SessionControls(OperatorState& s, InterfaceWindow& w, float width);

  float height() const;
  void draw();
  /// There is a picture, so the controls have an effect.
  bool possible() const;

 private:
  float first_line() const;

  void draw_clock();
  std::string end_label() const;

  std::vector<Flow::Item> session_items() const;
  void act(int pressed);

  static constexpr std::array kViews = {render::View::kLook, render::View::kSection, render::View::kXray,
                                        render::View::kDifference};
  std::vector<Flow::Item> view_items() const;
  void look(int pressed);
  void see(render::View view);

  void draw_plane();

  struct Shown {
    std::string name;
    Tissue tissue = Tissue::kAir;  // shown or hidden, if `flag` is null
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

// The report of one session as a page. The functions are declared in the order in which their parts appear on the page.
// The functions about the result are defined in result_parts.cpp, the functions about the course of the session in
// course_parts.cpp, and all other functions in page.cpp.
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/session/page/course.h"
#include "engine/session/page/frame_stream.h"
#include "engine/session/page/plot.h"
#include "engine/session/page/words.h"
#include "engine/session/place.h"
#include "engine/session/report.h"
#include "engine/session/task.h"

namespace typodont::session {

/// Returns the beginning of the HTML page, from the doctype to the start of the body. The page loads no other files.
std::string page_head(Language language, const std::string& title);

/// Writes one page, and stores the data that its parts need.
class Page : private Words {
 public:
  Page(const SessionReader& session, const ReportOptions& options);

  std::string html();

 private:
  template <class... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }
  /// Draws a gauge. `mark` is the pass mark as a fraction, or negative if there is no pass mark.
  void gauge(double fraction, bool missed = false, double mark = -1);
  std::string tissue_text(std::size_t i) const;
  std::string title() const;
  double duration() const { return course_.count > 0 ? course_.t1 - course_.t0 : 0; }
  std::string duration_text() const;
  double healthy_removed() const;
  bool has_ideal() const { return options_.preparation && !options_.preparation->ideal.distance.empty(); }
  bool compares() const { return !options_.earlier.empty() || options_.expert; }

  void head();
  void warnings();
  void summary();
  void task();

  /// The views in which the pictures show the result, and the first view of the rotatable model.
  struct Views {
    ModelView above, front, side, angled;
    dvec3 to_right{1, 0, 0};
  };
  Views views() const;
  /// Returns the text for a view. It is, for example, "From the buccal side" if the scene states the tooth's
  /// orientation, otherwise "From the front". `name` is above, front, …
  std::string view_text(const ModelView& view, const char* name) const;
  void result_views();
  void worst_places();
  void color_bar();
  void viewer(const Views& at);
  /// Returns the model as text. Positions are 16-bit fractions of the result's bounds; normals and deviations have 8
  /// bits.
  std::string model_data(const Views& at) const;
  void sections(const Views& at);

  std::vector<SessionPicture> all_pictures() const;
  void pictures();
  void items();
  void comparison();
  void volumes();
  /// Writes the phases of an exercise in implant surgery, and the force in each phase.
  void implant();

  /// Returns the text of an event, in which tools and faults have names in the reader's language.
  std::string event_text(const SessionEvent& event) const;
  std::vector<TimePlot::Mark> marks() const;
  void plot(const char* key, const char* css, const char* unit, const Series& s, int decimals,
            const char* note = nullptr);
  void over_time();
  /// Draws a strip below the force plot. Its colours show which tissue the head touched.
  void touched();
  void faults();
  void timing();
  std::string three_nines() const { return language == Language::kGerman ? "99,9 %" : "99.9 %"; }
  /// Writes median, 99 % quantile, 99.9 % quantile and maximum of the loop's times in a live session.
  void loop_times(const LoopReport& loop);
  void real_time(const LoopReport& loop);
  void cpu_times();
  void sound_times();

  void frame_row(const FrameStream& frames, const char* key, std::string_view column, double scale, const char* unit,
                 bool least_is_worst = false);
  void headset();
  void picture();

  void events();
  void details();
  /// Writes the part about the program and the machine, which is a separate page on screen and on paper.
  void technical_page();
  bool has_timing() const { return !course_.cpu_us.empty() || session_.loop(); }

  const SessionReader& session_;
  const ReportOptions& options_;
  Course course_;
  ScoreInput input_;
  Score score_;
  std::string scene_name_;
  std::optional<Task> task_;
  std::optional<ToothSides> tooth_;
  std::string out_;
};

}  // namespace typodont::session

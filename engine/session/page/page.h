// The report of one session. result_parts.cpp writes the result, defect_parts.cpp the strokes that made defects,
// course_parts.cpp what happened over time, page.cpp the rest. Functions are in the order of the page.
#pragma once

#include <fmt/format.h>

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

/// Beginning of the page, from the doctype to the body. The page loads no other files.
std::string page_head(Language language, const std::string& title);

/// Writes the report page of a session, and stores the data for its parts.
class Page : private Words {
 public:
  Page(const SessionReader& session, const ReportOptions& options);

  std::string html();

 private:
  template <class... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    out_ += fmt::format(format, std::forward<Args>(args)...);
  }
  /// Begins a section with the heading say(key), whose HTML id is `"h-" + id`. A printed section stays on one sheet,
  /// unless it is long.
  enum class Length { kShort, kLong };
  void begin_section(std::string_view id, std::string_view key, Length length = Length::kShort);
  void end_section() { put("</section>\n"); }
  /// Begins a table in the section `id`, with the texts of its header. Columns are right-aligned up to `left_aligned`.
  void begin_table(std::string_view id, const std::vector<std::string>& heads, const std::string& caption = "",
                   std::size_t left_aligned = 99);
  void end_table() { put("</tbody></table></div>\n"); }
  /// Writes a bar that is full up to `fraction`. `mark`: pass mark as a fraction; negative: none.
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
  /// A date of the session as local time, escaped. The first one states the time zone.
  std::string date_once_with_zone(const std::string& iso);
  /// How often a fault occurred and how long it lasted in all, for example "3 times, 1.20 s in all".
  std::string fault_times(const Course::FaultCount& fault) const;

  /// Views of the pictures, and the rotatable model's first view.
  struct Views {
    ModelView above, front, side, angled;
    dvec3 to_right{1, 0, 0};
  };
  Views views() const;
  /// Title of a view: "From the buccal side" if the tooth's orientation is known, otherwise "From the front". `name`:
  /// above, front, …
  std::string view_text(const ModelView& view, const char* name) const;
  /// Name of the place p_W on the tooth; its coordinates if the tooth's orientation is unknown.
  std::string place_words(const dvec3& p_W) const;
  void defects();
  void remarks();
  /// The strokes that made the defects, as data for the script, in the integer coordinates of the rotatable model.
  std::string stroke_data(const dvec3& middle_W, double step) const;
  void result_views();
  void worst_places();
  void color_bar();
  void viewer(const Views& at);
  /// The rotatable model as data for the script. Positions are 16-bit fractions of the model's bounds; normals and
  /// deviations have 8 bits.
  std::string model_data(const Views& at) const;
  void sections(const Views& at);

  std::vector<SessionPicture> all_pictures() const;
  void pictures();
  void items();
  void comparison();
  void volumes();
  /// Writes the part about implant surgery: phases and their forces.
  void implant();
  /// Writes the part about measured pockets: the readings of each site.
  void probing();

  /// Text of an event, with names of tools and faults in the reader's language.
  std::string event_text(const SessionEvent& event) const;
  std::vector<TimePlot::Mark> marks() const;
  /// Plots the temperature of a tissue. `curve`: °C at the end of each second.
  void temperature(const char* key, const std::vector<float>& curve);
  void plot(const char* key, const char* css, const char* unit, const Series& s, int decimals,
            const char* note = nullptr);
  void over_time();
  /// Draws a strip below the force plot that shows which tissue the head touched.
  void touched();
  void faults();
  void timing();
  std::string three_nines() const { return language == Language::kGerman ? "99,9 %" : "99.9 %"; }
  /// Table of the loop's times in a live session: median, 99 %, 99.9 %, maximum.
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
  /// Writes the part about program and machine, which a screen shows as a separate page.
  void technical_page();

  const SessionReader& session_;
  const ReportOptions& options_;
  Course course_;
  ScoreInput input_;
  Score score_;
  std::string scene_name_;
  std::optional<Task> task_;
  std::optional<ToothSides> tooth_;
  bool zone_stated_ = false;
  std::string out_;
};

}  // namespace typodont::session

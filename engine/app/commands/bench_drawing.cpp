#include "engine/app/commands/bench_drawing.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/late_library.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

constinit LateLibrary cairo{TYPODONT_LATE_CAIRO};
TYPODONT_LATE(cairo, cairo_pdf_surface_create_for_stream, cairo_svg_surface_create_for_stream, cairo_create,
              cairo_pdf_surface_set_metadata, cairo_svg_surface_set_document_unit, cairo_set_line_cap,
              cairo_set_source_rgba, cairo_move_to, cairo_line_to, cairo_fill, cairo_arc, cairo_text_extents,
              cairo_rectangle, cairo_show_text, cairo_show_page, cairo_surface_finish, cairo_surface_status,
              cairo_status_to_string, cairo_set_line_width, cairo_set_dash, cairo_stroke, cairo_select_font_face,
              cairo_set_font_size, cairo_close_path, cairo_surface_destroy, cairo_destroy)

using display::BenchPlan;
using display::BenchSpec;

constexpr double kPaperPoint = 72 / 25.4;  // points (the drawing's unit of length) per millimetre of paper
constexpr double kWidth = 297 * kPaperPoint,
                 kHeight = 210 * kPaperPoint;                         // points, size of an A4 page in landscape format
constexpr double kTextSize = 7.5, kSmallSize = 6.5, kTitleSize = 13;  // points, heights of normal, small and title text

struct Colour {
  double r, g, b;
};
constexpr Colour kInk{0.1, 0.1, 0.12}, kFaint{0.55, 0.57, 0.6}, kPanel{0.75, 0.35, 0.05}, kGlass{0.1, 0.4, 0.8},
    kWork{0.1, 0.55, 0.25}, kArm{0.45, 0.3, 0.6}, kWrong{0.8, 0.05, 0.05};

struct At {
  double x, y;
};

cairo_status_t append(void* bytes, const unsigned char* data, unsigned length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

/// A page of the drawing. Coordinates are in points; y points down.
class Page {
 public:
  Page(std::string& bytes, FileKind kind)
      : surface_(kind == FileKind::kDocument ? cairo_pdf_surface_create_for_stream(append, &bytes, kWidth, kHeight)
                                             : cairo_svg_surface_create_for_stream(append, &bytes, kWidth, kHeight),
                 cairo_surface_destroy),
        cairo_(cairo_create(surface_.get()), cairo_destroy) {
    if (kind == FileKind::kDocument) {
      cairo_pdf_surface_set_metadata(surface_.get(), CAIRO_PDF_METADATA_TITLE, "Plan of a mirror bench");
    } else {
      cairo_svg_surface_set_document_unit(surface_.get(), CAIRO_SVG_UNIT_PT);
    }
    cairo_set_line_cap(get(), CAIRO_LINE_CAP_ROUND);
  }
  cairo_t* get() const { return cairo_.get(); }

  void colour(const Colour& c, double alpha = 1) const { cairo_set_source_rgba(get(), c.r, c.g, c.b, alpha); }
  /// Draws a line. `dashes`: lengths of dashes and gaps; empty: a continuous line.
  void line(At a, At b, const Colour& c, double width, const std::vector<double>& dashes = {}) const {
    cairo_move_to(get(), a.x, a.y), cairo_line_to(get(), b.x, b.y);
    stroke(c, width, dashes);
  }
  void outline(const std::vector<At>& corners, const Colour& c, double width,
               const std::vector<double>& dashes = {}) const {
    path(corners);
    stroke(c, width, dashes);
  }
  void fill(const std::vector<At>& corners, const Colour& c, double alpha = 1) const {
    colour(c, alpha);
    path(corners);
    cairo_fill(get());
  }
  void disc(At at, double radius, const Colour& c) const {
    colour(c);
    cairo_arc(get(), at.x, at.y, radius, 0, 2 * kPi);
    cairo_fill(get());
  }
  /// Draws text on a white background, so that lines do not cross it. `align` is 0 if the text begins at `at`, 0.5 if
  /// `at` is its middle, and 1 if it ends at `at`.
  void text(At at, const std::string& text, const Colour& c = kInk, double size = kTextSize, double align = 0,
            bool bold = false) const {
    font(size, bold);
    cairo_text_extents_t extents;
    cairo_text_extents(get(), text.c_str(), &extents);
    const At from{at.x - align * extents.x_advance, at.y};
    colour({1, 1, 1}, 0.85);
    cairo_rectangle(get(), from.x - 1, from.y - 0.8 * size, extents.x_advance + 2, 1.05 * size);
    cairo_fill(get());
    colour(c);
    cairo_move_to(get(), from.x, from.y);
    cairo_show_text(get(), text.c_str());
  }
  /// Draws a dimension: a line with a short mark at each end, and the text `value` beside its middle.
  void measure(At a, At b, const std::string& value) const {
    line(a, b, kInk, 0.5);
    const double dx = b.x - a.x, dy = b.y - a.y, length = std::max(1e-9, std::hypot(dx, dy));
    const At across{-dy / length * 3, dx / length * 3};
    for (const At& end : {a, b})
      line({end.x - across.x, end.y - across.y}, {end.x + across.x, end.y + across.y}, kInk, 0.5);
    text({0.5 * (a.x + b.x), 0.5 * (a.y + b.y) + 0.35 * kTextSize}, value, kInk, kTextSize, 0.5);
  }
  void finish() const {
    cairo_show_page(get());
    cairo_surface_finish(surface_.get());
    if (const auto status = cairo_surface_status(surface_.get()); status != CAIRO_STATUS_SUCCESS)
      throw RunFailure(fmt::format("drawing: {}", cairo_status_to_string(status)));
  }

 private:
  void stroke(const Colour& c, double width, const std::vector<double>& dashes) const {
    colour(c);
    cairo_set_line_width(get(), width);
    cairo_set_dash(get(), dashes.data(), static_cast<int>(dashes.size()), 0);
    cairo_stroke(get());
  }
  void font(double size, bool bold = false) const {
    cairo_select_font_face(get(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(get(), size);
  }
  void path(const std::vector<At>& corners) const {
    cairo_move_to(get(), corners[0].x, corners[0].y);
    for (std::size_t i = 1; i < corners.size(); ++i) cairo_line_to(get(), corners[i].x, corners[i].y);
    cairo_close_path(get());
  }

  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface_;
  std::unique_ptr<cairo_t, void (*)(cairo_t*)> cairo_;
};

/// A drawn view of the workbench in a rectangle on the page. The page is parallel to two axes of frame W; the view is
/// along the third axis.
struct View {
  double left, top, width, height;  // points, position and size on the page
  int across, up;                   // indices of the two axes of frame W that point right and up on the page
  double scale = 1;                 // points on the page per metre
  dvec3 middle{0};                  // m, frame W: the point in the view's middle
  At operator()(const dvec3& p) const {
    return {left + 0.5 * width + scale * (p[across] - middle[across]),
            top + 0.5 * height - scale * (p[up] - middle[up])};
  }
};

std::string mm(double metres) {
  return fmt::format("{:.0f}", metres / kMillimetre + 0.0);
}
std::string mm(const dvec3& p) {
  return fmt::format("({:.0f}, {:.0f}, {:.0f})", p.x / kMillimetre + 0.0, p.y / kMillimetre + 0.0,
                     p.z / kMillimetre + 0.0);
}
std::string whole_degrees(double rad) {
  return fmt::format("{:.0f}°", rad / kDegree + 0.0);
}

std::array<dvec3, 4> corners_of(const display::Screen& screen) {
  return {screen.lower_left, screen.lower_right, screen.upper_left + screen.lower_right - screen.lower_left,
          screen.upper_left};
}

/// Projects the corners of a box to the page.
std::vector<At> shown(const View& view, const dvec3& low, const dvec3& high) {
  dvec3 c = low, d = high;
  c[view.across] = high[view.across], d[view.across] = low[view.across];
  c[view.up] = low[view.up], d[view.up] = high[view.up];
  return {view(low), view(c), view(high), view(d)};
}

class Drawing {
 public:
  Drawing(const BenchSpec& spec, const BenchPlan& plan, const Page& page) : spec_(spec), plan_(plan), page_(page) {
    choose_scale();
  }

  void draw() {
    page_.fill({{0, 0}, {kWidth, 0}, {kWidth, kHeight}, {0, kHeight}}, {1, 1, 1});
    page_.text({30, 34}, "Plan of a mirror bench", kInk, kTitleSize, 0, true);
    page_.text(
        {30, 47},
        fmt::format("Lengths in mm, scale 1 : {:g}. Origin: the middle of the work; x to the user's right, y away "
                    "from the user, z up.",
                    ratio_));
    side_view();
    top_view();
    table();
  }

 private:
  // Chooses one scale for both views of the workbench from a list of usual drawing scales.
  void choose_scale() {
    std::vector<dvec3> points{plan_.rig.head.eye_center, dvec3(0, 0, -0.5 * spec_.arm_box.z), 0.5 * spec_.arm_box,
                              -0.5 * spec_.arm_box};
    for (const dvec3& p : corners_of(plan_.rig.screen)) points.push_back(p);
    for (const dvec3& p : corners_of(plan_.picture)) points.push_back(p);
    for (const dvec3& p : plan_.glass) points.push_back(p);
    dvec3 low = points[0], high = points[0];
    for (const dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
    const dvec3 size = high - low;
    for (const double ratio : {1.0, 2.0, 2.5, 4.0, 5.0, 7.5, 10.0, 15.0, 20.0, 50.0, 100.0, 200.0, 500.0}) {
      ratio_ = ratio;
      const double scale = 1e3 * kPaperPoint / ratio;
      if (size.y * scale < side_.width - 110 && size.z * scale < side_.height - 90 &&
          size.x * scale < top_.width - 60 && size.y * scale < top_.height - 40)
        break;
    }
    side_.scale = top_.scale = 1e3 * kPaperPoint / ratio_;
    side_.middle = top_.middle = 0.5 * (low + high);
  }

  void frame(const View& view, const char* title) const {
    page_.outline({{view.left, view.top},
                   {view.left + view.width, view.top},
                   {view.left + view.width, view.top + view.height},
                   {view.left, view.top + view.height}},
                  kFaint, 0.4);
    page_.text({view.left + 6, view.top + 13}, title, kInk, kTextSize + 1, 0, true);
  }

  void boxes(const View& view) const {
    page_.outline(shown(view, -0.5 * spec_.arm_box, 0.5 * spec_.arm_box), kArm, 0.9, {1, 2.5});
    if (plan_.low == plan_.high) return;
    page_.fill(shown(view, plan_.low, plan_.high), kWork, 0.35);
    page_.outline(shown(view, plan_.low, plan_.high), kWork, 0.9);
  }

  void side_view() const {
    const View& view = side_;
    frame(view, "From the user's right");
    const dvec3& eye = plan_.rig.head.eye_center;
    const auto panel = corners_of(plan_.rig.screen), picture = corners_of(plan_.picture);
    // Draws the light rays from the panel's edges to the mirror glass, and from there to the eyes. Dashed lines
    // continue the reflected rays behind the glass, to the points from which the light seems to come.
    for (const std::size_t corner : {0u, 2u}) {
      // Index of the panel's corner whose mirror image is picture[corner]: the reflection exchanges corners 0 and 1,
      // and corners 2 and 3.
      const std::size_t other = corner == 0 ? 1 : 3;
      const dvec3 at = on_glass(picture[corner]);
      page_.line(view(eye), view(at), kFaint, 0.4);
      page_.line(view(at), view(panel[other]), kFaint, 0.4);
      page_.line(view(at), view(picture[corner]), kFaint, 0.4, {2, 2});
    }
    boxes(view);
    page_.line(view(eye), view(dvec3(0)), kInk, 0.6, {4, 2, 1, 2});
    page_.line(view(picture[0]), view(picture[3]), kPanel, 1.2, {4, 3});
    page_.line(view(panel[0]), view(panel[3]), kPanel, 2.6);
    page_.line(view(plan_.glass[0]), view(plan_.glass[3]), kGlass, 2);
    page_.disc(view(eye), 3, kInk);
    page_.disc(view(dvec3(0)), 1.6, kInk);

    // Draws the names of the bench's parts.
    const auto label = [&](const dvec3& p, double dx, double dy, const Colour& colour, const std::string& text,
                           double align = 0) {
      const At at = view(p);
      page_.text({at.x + dx, at.y + dy}, text, colour, kTextSize, align);
    };
    const dvec3& panel_top = panel[0].z > panel[3].z ? panel[0] : panel[3];
    label(panel_top, 0, -8, kPanel,
          fmt::format("panel {} × {}, tilted {}", mm(spec_.panel_width), mm(spec_.panel_height),
                      whole_degrees(2 * spec_.mirror_tilt - spec_.picture_tilt)));
    label(plan_.glass[3], 6, -4, kGlass, "half mirror");
    label(plan_.glass[3], 6, 5, kGlass,
          fmt::format("{} × {}, tilted {}", mm(plan_.glass_width), mm(plan_.glass_length),
                      whole_degrees(spec_.mirror_tilt)));
    label(picture[3], 6, 3, kPanel, "picture");
    label(eye, 0, -8, kInk, fmt::format("eyes, {} apart", mm(spec_.ipd)), 0.5);
    label(0.5 * eye, -6, -4, kInk, fmt::format("{}, {} down", mm(spec_.eye_distance), whole_degrees(spec_.gaze)), 1);
    label(dvec3(0, 0.5 * spec_.arm_box.y, -0.5 * spec_.arm_box.z), 4, -2, kArm, "arm's reach");

    // Draws the dimensions of the bench, measured from the point at which the user works: at the left, the heights
    // above this point; at the bottom, the distances from it.
    const double left = view.left + 16, right = view.left + view.width - 16;
    const At origin = view(dvec3(0));
    const auto dotted = [&](At a, At b) { page_.line(a, b, kFaint, 0.4, {1, 2}); };
    dotted({left - 4, origin.y}, {right, origin.y});
    dotted({left - 4, view(eye).y}, view(eye));
    page_.measure({left, origin.y}, {left, view(eye).y}, mm(eye.z));
    const double first = right - 34;
    for (std::size_t i = 0; i < 2; ++i) {
      const dvec3& edge = i == 0 ? panel[0] : panel[3];
      const At at = view(edge);
      const double x = first + 26 * static_cast<double>(i);
      dotted(at, {x + 4, at.y});
      page_.measure({x, origin.y}, {x, at.y}, mm(edge.z));
    }
    const double bottom = view.top + view.height - 12;
    dotted(origin, {origin.x, bottom + 4});
    dotted(view(eye), {view(eye).x, bottom + 4});
    page_.measure({view(eye).x, bottom}, {origin.x, bottom}, mm(-eye.y));
    for (const std::size_t corner : {0u, 3u})
      dotted(view(plan_.glass[corner]), {view(plan_.glass[corner]).x, bottom - 12 + 4});
    page_.measure({view(plan_.glass[0]).x, bottom - 14}, {view(plan_.glass[3]).x, bottom - 14},
                  mm(plan_.glass[3].y - plan_.glass[0].y));
  }

  dvec3 on_glass(const dvec3& picture_point) const {
    const dvec3 &eye = plan_.rig.head.eye_center, d = picture_point - eye;
    const auto& mirror = *plan_.rig.mirror;
    return eye + ((mirror.offset - glm::dot(mirror.normal, eye)) / glm::dot(mirror.normal, d)) * d;
  }

  void top_view() const {
    const View& view = top_;
    frame(view, "From above");
    const auto panel = corners_of(plan_.rig.screen);
    const auto quad = [&](const std::array<dvec3, 4>& corners) {
      std::vector<At> points;
      for (const dvec3& corner : corners) points.push_back(view(corner));
      return points;
    };
    page_.fill(quad(plan_.glass), kGlass, 0.12);
    page_.outline(quad(plan_.glass), kGlass, 1);
    page_.outline(quad(panel), kPanel, 1.2);
    boxes(view);
    const dvec3 &eye = plan_.rig.head.eye_center, half(0.5 * spec_.ipd, 0, 0);
    page_.disc(view(eye - half), 2.5, kInk);
    page_.disc(view(eye + half), 2.5, kInk);
    page_.disc(view(dvec3(0)), 1.6, kInk);
    const double right = view.left + view.width - 14;
    const At near = view(plan_.glass[1]), far = view(plan_.glass[2]);
    page_.measure({right, near.y}, {right, far.y}, mm(plan_.glass[2].y - plan_.glass[1].y));
    const double bottom = view.top + view.height - 10;
    page_.measure({view(plan_.glass[0]).x, bottom}, {near.x, bottom}, fmt::format("glass {}", mm(plan_.glass_width)));
    page_.measure({view(panel[1]).x, view.top + 26}, {view(panel[0]).x, view.top + 26},
                  fmt::format("panel {}", mm(spec_.panel_width)));
  }

  void table() const {
    double y = top_.top + top_.height + 16;
    const double left = top_.left, value = left + 92;
    const auto row = [&](const std::string& name, const std::string& text, const Colour& colour = kInk) {
      page_.text({left, y}, name, colour, kSmallSize, 0, true);
      page_.text({value, y}, text, colour, kSmallSize);
      y += 9.4;
    };
    const auto& screen = plan_.rig.screen;
    row("panel", fmt::format("lower left {}, lower right {}", mm(screen.lower_left), mm(screen.lower_right)), kPanel);
    row("", fmt::format("upper left {}: as its picture is upright", mm(screen.upper_left)), kPanel);
    row("half mirror", fmt::format("near left {}, near right {}", mm(plan_.glass[0]), mm(plan_.glass[1])), kGlass);
    row("", fmt::format("far right {}, far left {}", mm(plan_.glass[2]), mm(plan_.glass[3])), kGlass);
    row("eyes", fmt::format("midway at {}, {} apart", mm(plan_.rig.head.eye_center), mm(spec_.ipd)));
    row("arm",
        fmt::format("middle of its reach at (0, 0, 0), {} × {} × {}", mm(spec_.arm_box.x), mm(spec_.arm_box.y),
                    mm(spec_.arm_box.z)),
        kArm);
    if (plan_.low != plan_.high) {
      const dvec3 size = plan_.high - plan_.low;
      row("workspace",
          fmt::format("{} × {} × {}, from {} to {}", mm(size.x), mm(size.y), mm(size.z), mm(plan_.low), mm(plan_.high)),
          kWork);
      constexpr const char* kSides[] = {"left", "right", "near", "far", "lower", "upper"};
      for (std::size_t f = 0; f < 6; f += 2) {
        row(f == 0 ? "limited by" : "",
            fmt::format("{}: {}; {}: {}", kSides[f], plan_.faces[f].limit, kSides[f + 1], plan_.faces[f + 1].limit));
      }
    }
    row("pixel", fmt::format("{:.2f} mm wide in each eye's picture", plan_.pixel / kMillimetre));
    if (plan_.conflicts.empty()) {
      row("fits", "nothing is in the way", kWork);
    } else {
      for (const std::string& conflict : plan_.conflicts) row("does not fit", conflict, kWrong);
    }
  }

  const BenchSpec& spec_;
  const BenchPlan& plan_;
  const Page& page_;
  View side_{30, 58, 430, 500, 1, 2};
  View top_{472, 58, 340, 330, 0, 1};
  double ratio_ = 1;  // denominator of the drawing's scale 1 : ratio
};

}  // namespace

std::string draw_bench(const BenchSpec& spec, const BenchPlan& plan, FileKind kind) {
  std::string bytes;
  const Page page(bytes, kind);
  Drawing(spec, plan, page).draw();
  page.finish();
  return bytes;
}

}  // namespace typodont

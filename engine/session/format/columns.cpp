#include "engine/session/format/columns.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "engine/base/units.h"
#include "engine/session/session_data.h"

namespace typodont::session {

namespace {

// Units in files. An SI value is multiplied by a power of ten, which a double stores exactly, so the conversion rounds
// only once. The conversion back is a division, which also rounds once.
struct Millimetres {
  static constexpr const char* kName = "mm";
  static double to_file(double si) { return si * 1e3; }
  static double to_si(double v) { return v / 1e3; }
};
struct NewtonMillimetres : Millimetres {
  static constexpr const char* kName = "Nmm";
};
struct Millijoules : Millimetres {
  static constexpr const char* kName = "mJ";
};
struct SquareMillimetres {
  static constexpr const char* kName = "mm^2";
  static double to_file(double si) { return si * 1e6; }
  static double to_si(double v) { return v / 1e6; }
};
struct CubicMillimetres {
  static constexpr const char* kName = "mm^3";
  static double to_file(double si) { return si * 1e9; }
  static double to_si(double v) { return v / 1e9; }
};
struct Metres {
  static constexpr const char* kName = "m";
  static double to_file(double si) { return si; }
  static double to_si(double v) { return v; }
};
struct Newtons : Metres {
  static constexpr const char* kName = "N";
};
struct NoUnit : Metres {
  static constexpr const char* kName = "";
};
struct Krpm {
  static constexpr const char* kName = "krpm";
  static double to_file(double si) { return si / kKrpm; }
  static double to_si(double v) { return v * kKrpm; }
};

/// Makes a column that stores the exact bits of a message's field. `Field` is a lambda without captures that returns
/// the field of a message.
template <class Message, class Field>
Column<Message> exact(std::string name, std::string unit, std::string text, Field) {
  using T = std::remove_cvref_t<decltype(Field{}(std::declval<Message&>()))>;
  Column<Message> column{std::move(name), std::move(unit), std::move(text), type_of<T>()};
  column.get = [](const Message& m, std::byte* out) {
    const T value = Field{}(const_cast<Message&>(m));
    std::memcpy(out, &value, sizeof value);
  };
  column.set = [](Message& m, const std::byte* in) { std::memcpy(&Field{}(m), in, sizeof(T)); };
  return column;
}

/// Makes a column that stores doubles in the unit `Unit`, e.g. mm.
template <class Unit, class Message, class Field>
Column<Message> scaled(std::string name, std::string text, Field) {
  Column<Message> column{std::move(name), Unit::kName, std::move(text), Type::kF64};
  column.get = [](const Message& m, std::byte* out) {
    const double value = Unit::to_file(Field{}(const_cast<Message&>(m)));
    std::memcpy(out, &value, sizeof value);
  };
  column.set = [](Message& m, const std::byte* in) {
    double value;
    std::memcpy(&value, in, sizeof value);
    Field{}(m) = Unit::to_si(value);
  };
  return column;
}

/// Makes a column whose value is computed from other fields when it is written. The column is ignored when the file is
/// read.
template <class Message, class Value>
Column<Message> derived(std::string name, std::string unit, std::string text, Value) {
  Column<Message> column{std::move(name), std::move(unit), std::move(text), Type::kF64};
  column.get = [](const Message& m, std::byte* out) {
    const double value = Value{}(m);
    std::memcpy(out, &value, sizeof value);
  };
  return column;
}

template <class Message>
Column<Message> only_in_file(Column<Message> column) {
  column.in_csv = false;
  return column;
}

template <class Message>
Column<Message> added_later(Column<Message> column) {
  column.added = true;
  return column;
}

template <class Message, std::size_t... kIndex>
void add_removed(std::vector<Column<Message>>& columns, const char* when, std::index_sequence<kIndex...>) {
  // Air (index 0) has no column, because it cannot be removed.
  (columns.push_back(
       scaled<CubicMillimetres, Message>(fmt::format("removed_{}_mm3", name_of(static_cast<Tissue>(kIndex + 1))),
                                         fmt::format("{} cut away {}", name_of(static_cast<Tissue>(kIndex + 1)), when),
                                         [](Message& m) -> double& { return m.removed[kIndex + 1]; })),
   ...);
}
using Solids = std::make_index_sequence<kTissueCount - 1>;

template <class Message, std::size_t... kIndex>
void add_removed_exact(std::vector<Column<Message>>& columns, std::index_sequence<kIndex...>) {
  (columns.push_back(exact<Message>(fmt::format("removed_{}_m3", name_of(static_cast<Tissue>(kIndex + 1))), "m^3",
                                    fmt::format("{} cut away by this cut", name_of(static_cast<Tissue>(kIndex + 1))),
                                    [](Message& m) -> double& { return m.removed[kIndex + 1]; })),
   ...);
}

/// Adds three columns. In `name` and `text`, {} is the letter of the axis. `Vector` is a lambda without captures that
/// returns a vector of a message.
template <class Unit, class Message, class Vector>
void add_vector(std::vector<Column<Message>>& columns, std::string_view name, std::string_view text, Vector) {
  const auto add = [&](char axis, auto field) {
    columns.push_back(
        scaled<Unit, Message>(fmt::format(fmt::runtime(name), axis), fmt::format(fmt::runtime(text), axis), field));
  };
  add('x', [](Message& m) -> double& { return Vector{}(m).x; });
  add('y', [](Message& m) -> double& { return Vector{}(m).y; });
  add('z', [](Message& m) -> double& { return Vector{}(m).z; });
}

/// Makes the columns of a unit quaternion with its exact bits. `PoseOf` is a lambda without captures that returns a
/// Pose of a message.
template <class Message, class PoseOf>
void add_orientation(std::vector<Column<Message>>& columns, const std::string& prefix, const std::string& text,
                     PoseOf) {
  const auto add = [&](const char* name, auto field) {
    columns.push_back(only_in_file(exact<Message>(prefix + name, "", text + ", unit quaternion into W", field)));
  };
  add("_qw", [](Message& m) -> double& { return PoseOf{}(m).R.w; });
  add("_qx", [](Message& m) -> double& { return PoseOf{}(m).R.x; });
  add("_qy", [](Message& m) -> double& { return PoseOf{}(m).R.y; });
  add("_qz", [](Message& m) -> double& { return PoseOf{}(m).R.z; });
}

template <class Message, class PoseOf>
void add_pose(std::vector<Column<Message>>& columns, const std::string& prefix, const std::string& text,
              PoseOf pose_of) {
  add_vector<Metres>(columns, prefix + "_{}_m", text + ", {} in W, every bit",
                     [](Message& m) -> dvec3& { return PoseOf{}(m).p; });
  for (std::size_t i = columns.size() - 3; i < columns.size(); ++i) columns[i].in_csv = false;
  add_orientation(columns, prefix, text, pose_of);
}

std::vector<Column<ServoTick>> make_tick_columns() {
  using T = ServoTick;
  std::vector<Column<T>> c;

  // The columns have the order of docs/interface.md, section 'Ticks'.
  Column<T> t_s = derived<T>("t_s", "s", "when the hand was sampled, since the session's start",
                             [](const T& t) { return static_cast<double>(t.t) / 1e9; });
  t_s.set = [](T& t, const std::byte* in) {
    double s;
    std::memcpy(&s, in, sizeof s);
    t.t = std::isfinite(s) && std::abs(s) < 9e9 ? static_cast<Nanos>(std::llround(s * 1e9)) : 0;
  };
  c.push_back(t_s);
  add_vector<Millimetres>(c, "hand_{}_mm", "head centre where the hand holds it, {} in W",
                          [](T& t) -> dvec3& { return t.X_WT.p; });
  add_vector<Millimetres>(c, "tool_{}_mm", "head centre as held outside the tissue (drawn), {} in W",
                          [](T& t) -> dvec3& { return t.X_WG.p; });
  add_vector<Newtons>(c, "force_{}_N", "force on the hand, {} in W", [](T& t) -> dvec3& { return t.f_T_W; });
  add_vector<NewtonMillimetres>(c, "torque_{}_Nmm", "torque on the hand about the head centre, {} in W",
                                [](T& t) -> dvec3& { return t.tau_T_W; });
  c.push_back(scaled<Millimetres, T>("depth_mm", "distance from tool to hand position",
                                     [](T& t) -> double& { return t.depth; }));
  add_vector<NoUnit>(c, "normal_{}", "surface normal at the contact, out of the tissue, {} in W; 0 when free",
                     [](T& t) -> dvec3& { return t.n_C_W; });
  c.push_back(scaled<SquareMillimetres, T>("contact_area_mm2", "area of the head that touches tissue",
                                           [](T& t) -> double& { return t.contact_area; }));
  c.push_back(derived<T>("removed_mm3", "mm^3", "all tissue cut away since the start",
                         [](const T& t) { return total(t.removed) * 1e9; }));
  add_removed(c, "since the start", Solids{});
  Column<T> tissue = exact<T>("tissue", "", "what the head touches most", [](T& t) -> Tissue& { return t.tissue; });
  tissue.set = [](T& t, const std::byte* in) {
    t.tissue = std::to_integer<int>(*in) < kTissueCount ? static_cast<Tissue>(*in) : Tissue::kAir;
  };
  c.push_back(tissue);
  c.push_back(scaled<Krpm, T>("spindle_krpm", "speed of the spindle", [](T& t) -> double& { return t.spindle; }));
  c.push_back(scaled<Millijoules, T>("energy_mJ", "passivity observer: energy taken from the hand so far",
                                     [](T& t) -> double& { return t.energy; }));
  Column<T> tick_us = derived<T>("tick_us", "us", "thread CPU time of the tick",
                                 [](const T& t) { return static_cast<double>(t.cpu_time) / 1e3; });
  tick_us.set = [](T& t, const std::byte* in) {
    double us;
    std::memcpy(&us, in, sizeof us);
    t.cpu_time = std::isfinite(us) && std::abs(us) < 9e15 ? static_cast<Nanos>(std::llround(us * 1e3)) : 0;
  };
  c.push_back(tick_us);
  c.push_back(exact<T>("faults", "", "what went wrong, as bits", [](T& t) -> std::uint32_t& { return t.faults; }));
  c.push_back(exact<T>("pedal", "", "foot pedal, 0 to 1", [](T& t) -> double& { return t.pedal; }));
  c.push_back(added_later(exact<T>("tool", "", "which of the session's tools is in the hand",
                                   [](T& t) -> std::uint32_t& { return t.tool; })));

  // The following columns are computed by contact models. Only CSV tables have them. Session files do not, because a
  // replay computes the values again.
  const auto model_force = [&](const char* name, const char* text, auto field) {
    Column<T> column = added_later(exact<T>(name, "N", text, field));
    column.in_file = false;
    c.push_back(column);
  };
  model_force("model_force_x_N", "force that the contact model asks for, before slews, limits and ledger",
              [](T& t) -> double& { return t.f_model_W.x; });
  model_force("model_force_y_N", "the same", [](T& t) -> double& { return t.f_model_W.y; });
  model_force("model_force_z_N", "the same", [](T& t) -> double& { return t.f_model_W.z; });
  // Session files contain the column `level`, too: for the model `implant`, it is the tool's state, used by the score.
  c.push_back(added_later(exact<T>("level", "", "level of detail of the contact model, or its state; 0: the finest",
                                   [](T& t) -> std::uint32_t& { return t.level; })));

  c.push_back(
      added_later(exact<T>("wear", "", "of the tool: at equal power, it removes 1 + wear times less than a new one",
                           [](T& t) -> double& { return t.wear; })));

  // A replay needs the following columns with their exact bits.
  c.push_back(only_in_file(exact<T>("index", "", "ticks since the servo started; a gap is a lost tick",
                                    [](T& t) -> std::uint64_t& { return t.index; })));
  c.push_back(only_in_file(exact<T>("t_ns", "ns", "t_s, every bit", [](T& t) -> Nanos& { return t.t; })));
  add_pose<T>(c, "hand", "the tool where the hand holds it", [](T& t) -> Pose& { return t.X_WT; });
  add_orientation<T>(c, "tool", "the tool as drawn", [](T& t) -> Pose& { return t.X_WG; });
  c.push_back(only_in_file(exact<T>("cutting_power_W", "W", "power that goes into cutting",
                                    [](T& t) -> double& { return t.cutting_power; })));
  c.push_back(only_in_file(exact<T>("patch", "", "number of the tissue patch of this tick; 0: none",
                                    [](T& t) -> std::uint32_t& { return t.patch; })));
  c.push_back(only_in_file(
      exact<T>("cuts", "", "cuts made so far, this tick's included", [](T& t) -> std::uint64_t& { return t.cuts; })));
  return c;
}

std::vector<Column<Cut>> make_cut_columns() {
  using T = Cut;
  std::vector<Column<T>> c;
  c.push_back(
      exact<T>("index", "", "1, 2, 3 ...; a gap is a lost cut", [](T& t) -> std::uint64_t& { return t.index; }));
  c.push_back(exact<T>("tick", "", "index of the tick that made it", [](T& t) -> std::uint64_t& { return t.tick; }));
  c.push_back(exact<T>("t_ns", "ns", "when, since the session's start", [](T& t) -> Nanos& { return t.t; }));
  add_pose<T>(c, "a", "the head before", [](T& t) -> Pose& { return t.X_WA; });
  add_pose<T>(c, "b", "the head after", [](T& t) -> Pose& { return t.X_WB; });
  c.push_back(exact<T>("tool", "", "which of the session's tools", [](T& t) -> std::uint32_t& { return t.tool; }));
  add_removed_exact(c, Solids{});
  add_vector<NoUnit>(c, "normal_{}", "surface normal, out of the tissue, {} in W",
                     [](T& t) -> dvec3& { return t.n_C_W; });
  c.push_back(exact<T>("spindle_rad_per_s", "rad/s", "speed of the spindle, signed about the tool's z",
                       [](T& t) -> double& { return t.spindle; }));
  c.push_back(added_later(exact<T>("fill_radius_m", "m", "of the ball that was filled; 0: a cut",
                                   [](T& t) -> double& { return t.fill_radius; })));
  return c;
}

std::vector<Column<PatchUse>> make_patch_columns() {
  using T = PatchUse;
  std::vector<Column<T>> c;
  c.push_back(exact<T>("patch", "", "its number, 1, 2, 3 ...", [](T& t) -> std::uint32_t& { return t.patch; }));
  c.push_back(exact<T>("first_tick", "", "index of the first tick computed in it",
                       [](T& t) -> std::uint64_t& { return t.first_tick; }));
  c.push_back(exact<T>("cuts", "", "cuts already in the tissue when it was cut out",
                       [](T& t) -> std::uint64_t& { return t.cuts; }));
  add_vector<Metres>(c, "center_{}_m", "where it was asked for, {} in W", [](T& t) -> dvec3& { return t.center_W; });
  return c;
}

}  // namespace

const std::vector<Column<ServoTick>>& tick_columns() {
  static const auto columns = make_tick_columns();
  return columns;
}
const std::vector<Column<Cut>>& cut_columns() {
  static const auto columns = make_cut_columns();
  return columns;
}
const std::vector<Column<PatchUse>>& patch_columns() {
  static const auto columns = make_patch_columns();
  return columns;
}

std::string tissue_labels() {
  std::string text;
  for (int i = 0; i < kTissueCount; ++i) {
    text += fmt::format("{}{} {}", i ? ", " : "", i, name_of(static_cast<Tissue>(i)));
  }
  return text;
}

std::string fault_labels() {
  std::string text;
  for (const FaultName& fault : fault_names()) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", bits(fault.fault), fault.name);
  }
  return text;
}

const std::vector<FaultName>& fault_names() {
  static const std::vector<FaultName> names = {
      {Fault::kBadInput, "bad_input"},
      {Fault::kStalePatch, "stale_patch"},
      {Fault::kPatchEdge, "patch_edge"},
      {Fault::kForceLimit, "force_limit"},
      {Fault::kDeepPenetration, "deep_penetration"},
      {Fault::kDeviceLost, "device_lost"},
      {Fault::kSlewLimit, "slew_limit"},
      {Fault::kOverrun, "overrun"},
      {Fault::kLetGo, "let_go"},
      {Fault::kNoRoom, "no_room"},
      {Fault::kHeld, "held"},
      {Fault::kWedged, "wedged"},
  };
  return names;
}

std::string_view fault_name(std::uint32_t bit) noexcept {
  for (const FaultName& fault : fault_names()) {
    if (bits(fault.fault) == bit) return fault.name;
  }
  return "unknown";
}

}  // namespace typodont::session

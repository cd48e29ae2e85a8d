#include "engine/bindings/c/call.h"

#include <exception>

#include "haptics/contact_method.h"

namespace typodont::bindings {

namespace {

// The message is stored as a pointer, because the C library reserves little thread-local memory for libraries that are
// loaded late. Copied texts are on the heap.
constinit thread_local const char* t_error = "";
thread_local std::string t_copy;  // the text to which t_error points if it was copied

}  // namespace

typodont_result fail(typodont_result result, const char* literal) noexcept {
  t_error = literal;
  return result;
}

typodont_result fail_with_copy(typodont_result result, const char* text) noexcept {
  try {
    t_copy = text;
  } catch (const std::bad_alloc&) {
    return fail(result, "not enough memory for the text of the error");
  }
  return fail(result, t_copy.c_str());
}

typodont_result fail_by_exception() noexcept {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return fail(TYPODONT_NO_MEMORY, "not enough memory, or more than 4096 handles");
  } catch (const Error& e) {
    return fail_with_copy(TYPODONT_BAD_INPUT, e.what());
  } catch (const std::exception& e) {
    return fail_with_copy(TYPODONT_FAILED, e.what());
  } catch (...) {
    return fail(TYPODONT_FAILED, "an unknown error");
  }
}

std::recursive_mutex& SessionFiles::mutex() {
  static std::recursive_mutex one;
  return one;
}

// `__restrict`: the structs do not overlap, so 16 bytes are copied at a time.
void put(const ServoTick& __restrict from, typodont_tick& __restrict out) noexcept {
  out.faults = from.faults;
  out.index = from.index;
  out.t_ns = from.t;
  put(from.X_WT, out.X_WT);
  put(from.X_WG, out.X_WG);
  put(from.f_T_W, out.force);
  put(from.tau_T_W, out.torque);
  out.pedal = from.pedal;
  out.depth = from.depth;
  put(from.n_C_W, out.normal);
  out.contact_area = from.contact_area;
  put(from.removed, out.removed);
  out.spindle = from.spindle;
  out.cutting_power = from.cutting_power;
  out.energy = from.energy;
  out.spindle_energy = from.spindle_energy;
  put(from.f_model_W, out.model_force);
  out.cuts = from.cuts;
  out.cpu_ns = from.cpu_time;
  out.tissue = static_cast<std::uint32_t>(from.tissue);
  out.tool = from.tool;
  out.level = from.level;
  out.patch = from.patch;
  out.wear = from.wear;
}

void put(const Cut& from, typodont_cut& out) noexcept {
  out.tool = from.tool;
  out.index = from.index;
  out.tick = from.tick;
  out.t_ns = from.t;
  put(from.X_WA, out.X_WA);
  put(from.X_WB, out.X_WB);
  put(from.removed, out.removed);
  put(from.n_C_W, out.normal);
  out.spindle = from.spindle;
  out.fill_radius = from.fill_radius;
}

}  // namespace typodont::bindings

using namespace typodont;

const char* typodont_version(void) {
  return TYPODONT_VERSION;
}

const char* typodont_error(void) {
  return bindings::t_error;
}

const char* typodont_tissue_name(uint32_t tissue) {
  // A string literal, so it ends with a null character.
  return tissue < static_cast<std::uint32_t>(kTissueCount) ? name_of(static_cast<Tissue>(tissue)).data() : nullptr;
}

const char* typodont_model_name(uint32_t place) {
  static const std::vector<std::string> names = haptics::contact_method_names();
  return place < names.size() ? names[place].c_str() : nullptr;
}

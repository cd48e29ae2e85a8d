// Contact methods, by the names that a scene's key "model" and the option --model use.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "haptics/contact/contact_model.h"
#include "haptics/contact/tissue_body.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct ServoSettings;

/// A contact method with its parameters. Immutable; shared by servo and carver thread. Its make functions throw Error.
class ContactMethod {
 public:
  virtual ~ContactMethod() = default;
  virtual std::string_view name() const = 0;
  /// Returns true if the bodies of this method have their own triangles, which are drawn (TissueBody::surface).
  virtual bool draws_own_surface() const { return false; }
  /// Creates the model for the servo thread. `settings` must be complete, including `frame`, and outlive the model.
  virtual std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const = 0;
  /// Creates the body for the carver thread. `tools`: tools of the session, indexed by Cut::tool.
  virtual std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const = 0;
};
using SharedContactMethod = std::shared_ptr<const ContactMethod>;

/// Describes a method's parameters, and returns the method with the parameters that the scene states. Throws Error.
using ContactMethodReader = std::function<SharedContactMethod(Keys& keys)>;

/// Registers a contact method that another module defines. Declare an object at namespace scope:
///   const ContactMethodRegistration registration{"mine", [](Keys& keys) { … }};
/// Throws std::logic_error if the name already exists.
struct ContactMethodRegistration {
  ContactMethodRegistration(std::string name, ContactMethodReader reader);
};

/// Returns the method with default parameters. Throws Error with all known names. `where`: file or option that states
/// the name.
SharedContactMethod contact_method(std::string_view name, std::string_view where);
/// Reads a method: "offset", or {"offset": {parameters}}. Throws Error.
SharedContactMethod read_contact_method(const Json& json);
/// Adds the parameters of each method, under its name, to `keys`.
void list_contact_methods(Keys& keys);
/// Returns the names as users see them, without the alias "god-object" of "offset".
std::vector<std::string> contact_method_names();
/// Returns the names for messages: "one of: offset, …".
std::string known_contact_methods();

/// Number of models (servo thread) and bodies (carver thread) that this process has created.
struct MethodCount {
  std::string name;
  std::uint64_t models = 0, bodies = 0;
};
/// Counts in the order of contact_method_names(). Any thread.
std::vector<MethodCount> method_counts();

/// Returns the method used if none is chosen: "offset".
const SharedContactMethod& default_contact_method();

}  // namespace typodont::haptics

// What outside programs answer, and how they are named on the command line.
#include <consimd/studies/outside_program.hpp>

#include "holds.hpp"
#include "outside/reply_text.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace consimd;
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::may_refuse([&] {
    const studies::ReplyText reply = studies::parse_reply(text);
    fuzz::require(!reply.pose || reply.pose->matrix().allFinite(), "finite poses");
    fuzz::require(!reply.seconds || *reply.seconds >= 0.0, "times of zero or more");
  });
  fuzz::may_refuse([&] {
    const auto program = studies::parse_outside_program(text);
    fuzz::require(!program || !program->command.empty(), "programs with a command");
  });
  fuzz::require(studies::shown_text(text).size() < 70, "short messages");
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "ur/ur_script.hpp"

#include <sstream>

namespace robotskin::ur {

std::string script_text(const ScriptSettings& settings, std::int32_t program) {
  std::ostringstream values;
  for (int joint = 0; joint < 6; ++joint)
    values << (joint > 0 ? ", " : "[") << "read_input_float_register(" << value_register + joint << ")";
  values << "]";
  std::ostringstream text;
  text << "def robotskin_port():\n"
       << "  textmsg(\"robotskin: holding still until commands come\")\n"
       << "  write_output_integer_register(" << mode_register << ", " << program << ")\n"
       << "  local seen = read_input_integer_register(" << sequence_register << ")\n"
       << "  local quiet = " << settings.life_cycles << "\n"
       << "  local was = 1\n"
       << "  while True:\n"
       << "    local newest = read_input_integer_register(" << sequence_register << ")\n"
       << "    local mode = read_input_integer_register(" << mode_register << ")\n"
       << "    if newest == seen:\n"
       << "      quiet = quiet + 1\n"
       << "    else:\n"
       << "      quiet = 0\n"
       << "      seen = newest\n"
       << "    end\n"
       << "    write_output_integer_register(" << sequence_register << ", seen)\n"
       << "    if quiet >= " << settings.life_cycles << ":\n"
       << "      mode = 0\n"
       << "    end\n"
       << "    if mode == 1:\n"
       << "      servoj(" << values.str() << ", 0, 0, " << settings.step_s << ", " << settings.lookahead_s << ", "
       << settings.gain << ")\n"
       << "    elif mode == 2:\n"
       << "      speedj(" << values.str() << ", " << settings.acceleration << ", " << settings.step_s << ")\n";
  // A controller that does not know the function refuses a script with its name.
  if (settings.takes_torque)
    text << "    elif mode == 3:\n"
         << "      direct_torque(" << values.str() << ", friction_comp=False)\n";
  text << "    else:\n"
       << "      if was > 0:\n"
       << "        stopj(" << settings.stop_deceleration
       << ")\n"
       // What came while it braked may be old by now.
       << "        seen = read_input_integer_register(" << sequence_register << ")\n"
       << "      end\n"
       << "      sync()\n"
       << "    end\n"
       << "    was = mode\n"
       << "  end\n"
       << "end\n";
  return text.str();
}

}  // namespace robotskin::ur

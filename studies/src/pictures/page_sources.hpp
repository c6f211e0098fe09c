// The pages of this folder as the library holds them: what studies/CMakeLists.txt reads into it.
#pragma once

#include <string_view>

namespace consimd::studies {

extern const std::string_view kRegistrationPage;    ///< registration_page.html
extern const std::string_view kRegistrationScript;  ///< similarities.js, registration_shaders.js, registration_page.js
extern const std::string_view kStudyPage;           ///< study_page.html
extern const std::string_view kStudyScript;         ///< study_page.js

}  // namespace consimd::studies

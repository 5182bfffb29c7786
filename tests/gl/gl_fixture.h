#pragma once

#include <gtest/gtest.h>

#include <optional>

#include "engine/gl/device.h"
#include "engine/platform/headless.h"

namespace ff::test {

/// A headless context for a whole test case; the driver's errors fail the test that caused them.
class GlTest : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        auto opened = platform::HeadlessContext::open();
        ASSERT_TRUE(opened) << opened.error().message;
        context().emplace(std::move(*opened));
        gl::enable_debug_output();
    }
    static void TearDownTestSuite() { context().reset(); }
    void SetUp() override { ASSERT_TRUE(context().has_value()); }
    void TearDown() override { EXPECT_EQ(gl::debug_error_count(), 0); }

  private:
    static std::optional<platform::HeadlessContext>& context() {
        static std::optional<platform::HeadlessContext> context;
        return context;
    }
};

}  // namespace ff::test

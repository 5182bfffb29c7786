#pragma once
// GDAL, quiet and started once.

#include <cpl_error.h>
#include <gdal_priv.h>

#include <memory>
#include <mutex>

namespace ff::cook {

/// While it lives, GDAL's own messages stay off stderr; ours quote them. Registers the drivers on first use.
class GdalSession {
  public:
    GdalSession() {
        static std::once_flag once;
        std::call_once(once, [] { GDALAllRegister(); });
        CPLPushErrorHandler(CPLQuietErrorHandler);
        CPLErrorReset();
    }
    ~GdalSession() { CPLPopErrorHandler(); }
    GdalSession(const GdalSession&) = delete;
    GdalSession& operator=(const GdalSession&) = delete;
};

struct GdalDatasetCloser {
    void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using GdalDataset = std::unique_ptr<GDALDataset, GdalDatasetCloser>;

}  // namespace ff::cook

//! CSV: a row for each property with its standard deviation, interval, unit and covariances.

use super::heading;
use super::number::shortest;
use super::subject::ExportedResult;
use massline_result::{Error, Result};

/// A table below comment lines that begin with `#`.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    for line in heading::lines(exported, "") {
        bytes.extend(format!("# {line}\n").into_bytes());
    }
    let mut writer = ::csv::Writer::from_writer(bytes);
    let names = heading::order();
    let mut header: Vec<String> =
        ["name", "value", "sigma", "low95", "high95", "unit"].map(String::from).into();
    header.extend(names.map(|name| format!("cov_{name}")));
    let failed = |e: &dyn std::fmt::Display| {
        Error::internal("csv", format!("the table is not written: {e}"))
    };
    writer.write_record(&header).map_err(|e| failed(&e))?;
    let (value, sigma, interval) = (exported.theta(), exported.sigma(), exported.interval());
    let cell = |value: Option<f64>| value.map(shortest).unwrap_or_default();
    for (k, name) in names.into_iter().enumerate() {
        let mut row = vec![
            name.to_owned(),
            shortest(value[k]),
            cell(sigma.map(|sigma| sigma[k])),
            cell(interval.map(|[low, _]| low[k])),
            cell(interval.map(|[_, high]| high[k])),
            exported.units.unit_of(k),
        ];
        row.extend((0..10).map(|j| cell(exported.covariance().map(|c| c[(k, j)]))));
        writer.write_record(&row).map_err(|e| failed(&e))?;
    }
    writer.into_inner().map_err(|e| failed(&e))
}

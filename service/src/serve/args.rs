//! The options of `overcoat serve`.

use super::address::Network;
use super::socket::Address;
use crate::common::{ConverterArgs, bytes};
use clap::{Arg, Args};
use overcoat_cli::args::{DrawArgs, EncodingArgs};
use overcoat_cli::value_parsers::within;
use std::path::PathBuf;

/// `overcoat serve`
#[derive(Debug, Args)]
#[command(
    mut_arg("cache", of_one_process),
    after_help = "Every option can also be given by a variable of the environment (OVERCOAT_ and its name in capitals, as \
OVERCOAT_MAX_SIZE) and by a key of the configuration file (max_size = 1024). The command line wins over the environment, that over \
the file.

Examples:
  overcoat-service serve
  overcoat-service serve --listen 0.0.0.0:8080 --cache /var/cache/overcoat --cache-bytes 20Gi
  overcoat-service serve --config /etc/overcoat.toml
  curl --data-binary @model.glb 'localhost:8080/render?size=256&view=front' -o picture.png"
)]
pub struct ServeArgs {
    /// Configuration file (TOML): keys are the long names of these options
    #[arg(long, value_name = "FILE", help_heading = None::<&str>)]
    pub config: Option<PathBuf>,

    /// Address and port that are listened on, a port of this machine alone, or unix:PATH; port 0 takes a free one, which is printed
    #[arg(long, value_name = "[ADDRESS:]PORT", default_value = "127.0.0.1:8080", value_parser = Address::parse, help_heading = None::<&str>)]
    pub listen: Address,

    /// Address and port for metrics and health alone, as of --listen; /metrics is not on the other port then
    #[arg(long, value_name = "[ADDRESS:]PORT", value_parser = Address::parse, help_heading = "Connections")]
    pub metrics_listen: Option<Address>,

    /// Network of proxies whose X-Forwarded-For says who the client is, ADDRESS/BITS; may be repeated. With any, all that come over unix:PATH
    /// are proxies [default: none]
    #[arg(long, value_name = "NETWORK", value_delimiter = ',', value_parser = Network::new, help_heading = "Connections")]
    pub trusted_proxies: Vec<Network>,

    /// Connections at a time; for further ones those give way that wait for a request, of the client with most of them first
    #[arg(long, value_name = "N", default_value = "1024", value_parser = within::<usize>(1, 1 << 20), help_heading = "Connections")]
    pub max_connections: usize,

    /// Connections at a time of one address (IPv6: of one network of 64 bits); further ones are refused (429). --trusted-proxies may have
    /// any number [default: a quarter of all]
    #[arg(long, value_name = "N", value_parser = within::<usize>(1, 1 << 20), help_heading = "Connections")]
    pub client_connections: Option<usize>,

    /// Seconds that the head of a request may take (408)
    #[arg(long, value_name = "SECONDS", default_value = "15", value_parser = within::<f64>(0.01, 1e6), help_heading = "Connections")]
    pub header_seconds: f64,

    /// Seconds between an answer and the next request on its connection
    #[arg(long, value_name = "SECONDS", default_value = "15", value_parser = within::<f64>(0.01, 1e6), help_heading = "Connections")]
    pub idle_seconds: f64,

    /// Seconds that a client may take no more of an answer, and that an answer may take beside those of --write-rate
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = within::<f64>(0.01, 1e6), help_heading = "Connections")]
    pub write_seconds: f64,

    /// Bytes a second that an answer must be taken with on average
    #[arg(long, value_name = "BYTES", default_value = "4Ki", value_parser = bytes, help_heading = "Connections")]
    pub write_rate: u64,

    /// Bytes of a body, or of a model from a source with all its files; suffixes as of --limit
    #[arg(long, value_name = "BYTES", default_value = "64Mi", value_parser = bytes, help_heading = "Connections")]
    pub max_body: u64,

    /// Seconds that a body may take beside those of --body-rate
    #[arg(long, value_name = "SECONDS", default_value = "15", value_parser = within::<f64>(0.01, 1e6), help_heading = "Connections")]
    pub body_seconds: f64,

    /// Bytes a second that a body must have on average
    #[arg(long, value_name = "BYTES", default_value = "64Ki", value_parser = bytes, help_heading = "Connections")]
    pub body_rate: u64,

    /// Bytes of all bodies and sources that are kept in memory at a time
    #[arg(long, value_name = "BYTES", default_value = "512Mi", value_parser = bytes, help_heading = "Connections")]
    pub body_memory: u64,

    /// Seconds that accepted requests have to end after SIGTERM or SIGINT; a second signal ends at once
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = within::<f64>(0.0, 1e6), help_heading = "Connections")]
    pub stop_seconds: f64,

    /// Longest side of a picture that a request may ask for
    #[arg(long, value_name = "PIXELS", default_value = "2048", value_parser = within::<u32>(1, 32768), help_heading = "Pictures")]
    pub max_size: u32,

    /// Cache-Control of pictures
    #[arg(long, value_name = "TEXT", default_value = "public, max-age=3600", value_parser = header, help_heading = "Pictures")]
    pub cache_control: String,

    /// Picture (PNG, JPEG, WebP) for an <img> whose path has none: in place of the error, with its status [default: none]
    #[arg(long, value_name = "FILE", help_heading = "Pictures")]
    pub fallback: Option<PathBuf>,

    /// Environment that requests may name (env=NAME): an equirectangular picture (HDR, EXR, PNG, JPEG); may be repeated. In a file:
    /// [environment] sky = \"/srv/sky.hdr\"
    #[arg(long, value_name = "NAME=FILE", help_heading = "Pictures")]
    pub environment: Vec<String>,

    /// Options under a name, as in paths: thumb=size:256/view:front; may be repeated. In a file: [preset] thumb = \"...\"
    #[arg(long, value_name = "NAME=OPTIONS", help_heading = "Pictures")]
    pub preset: Vec<String>,

    /// File of offers (TOML): presets as tables, options that requests may use beside them and their values, and whether presets are
    /// all that is offered
    #[arg(long, value_name = "FILE", help_heading = "Pictures")]
    pub presets: Option<PathBuf>,

    /// Units that a request may cost; a unit is about 10 ms of one processor, and answers tell the price (Overcoat-Price) [default: any
    /// number]
    #[arg(long, value_name = "UNITS", value_parser = within::<u64>(1, u64::MAX), help_heading = "Pictures")]
    pub max_price: Option<u64>,

    /// Pictures that one request may ask for (presets, views, sizes)
    #[arg(long, value_name = "N", default_value = "16", value_parser = within::<usize>(1, 1000), help_heading = "Pictures")]
    pub max_pictures: usize,

    /// Where pictures are kept: a folder, or the URL of a prefix (s3://, gs://, az://) [default: nowhere]
    #[arg(id = "pictures", long = "cache", value_name = "DIR|URL", help_heading = "Cache")]
    pub cache: Option<String>,

    /// Bytes of the cache in a folder; what was not asked for longest goes first
    #[arg(long, value_name = "BYTES", default_value = "1Gi", value_parser = bytes, help_heading = "Cache")]
    pub cache_bytes: u64,

    /// Key of signatures, hexadecimal; several for rotation, each with its --salt [default: none, paths are refused]
    #[arg(long, value_name = "HEX", value_delimiter = ',', hide_env_values = true, help_heading = "Sources")]
    pub key: Vec<String>,

    /// Salt of signatures, hexadecimal; as many as there are keys
    #[arg(long, value_name = "HEX", value_delimiter = ',', hide_env_values = true, help_heading = "Sources")]
    pub salt: Vec<String>,

    /// File of bearer keys (TOML) with their holders, limits and quotas; SIGHUP reads it again. OVERCOAT_BEARER has keys beside it:
    /// NAME=KEY, with commas [default: none, nobody needs a key]
    #[arg(long, value_name = "FILE", help_heading = "Rights")]
    pub bearer_keys: Option<PathBuf>,

    /// Requests that need a bearer key, where there are any: uploads, or all for which a worker is needed
    #[arg(long, value_name = "WHICH", default_value = "uploads", value_parser = ["uploads", "all"], help_heading = "Rights")]
    pub bearer_for: String,

    /// Pages of this origin may use the service (CORS): https://example.com, or * for all; may be repeated [default: none]
    #[arg(long, value_name = "ORIGIN", value_delimiter = ',', value_parser = super::cors::origin, help_heading = "Rights")]
    pub cors_origin: Vec<String>,

    /// Print a path, from its options on, with its signature by the first key, and end: /size:256/plain/local://car.glb@png
    #[arg(long, value_name = "PATH", help_heading = "Sources")]
    pub sign: Option<String>,

    /// Take paths without a signature: unsafe or _ in its place
    #[arg(long, help_heading = "Sources")]
    pub allow_unsigned: bool,

    /// Serve signed paths alone: no /render, /pipeline, /info of bodies and no page
    #[arg(long, help_heading = "Sources")]
    pub signed_only: bool,

    /// Folder of sources local://PATH
    #[arg(long, value_name = "DIR", help_heading = "Sources")]
    pub local: Option<PathBuf>,

    /// Sources that begin with this URL may be read: https://example.com/models/, https://*.example.com, s3://bucket/models, or
    /// https:// for all of a scheme; may be repeated [default: none]
    #[arg(long, value_name = "URL", value_delimiter = ',', help_heading = "Sources")]
    pub allow_source: Vec<String>,

    /// Private network that sources may come from, ADDRESS/BITS; may be repeated [default: none]
    #[arg(long, value_name = "NETWORK", value_delimiter = ',', help_heading = "Sources")]
    pub allow_network: Vec<String>,

    /// Seconds that a source may take, with all its files
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = within::<f64>(0.01, 1e6), help_heading = "Sources")]
    pub source_seconds: f64,

    /// Folder of jobs (POST /jobs), which survive the end of the process; one service for each [default: no jobs are taken]
    #[arg(long, value_name = "DIR", help_heading = "Jobs")]
    pub spool: Option<PathBuf>,

    /// Jobs in the folder at a time; further ones are refused (429)
    #[arg(long, value_name = "N", default_value = "1000", value_parser = within::<usize>(1, 1 << 20), help_heading = "Jobs")]
    pub spool_jobs: usize,

    /// Bytes of their models together
    #[arg(long, value_name = "BYTES", default_value = "1Gi", value_parser = bytes, help_heading = "Jobs")]
    pub spool_bytes: u64,

    /// Results of jobs may be sent to what begins with this URL, at a public address or in an --allow-network; may be repeated
    /// [default: nowhere]
    #[arg(long, value_name = "URL", value_delimiter = ',', help_heading = "Jobs")]
    pub allow_callback: Vec<String>,

    /// Seconds until a callback that has failed is tried again, doubled each time up to an hour
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = within::<f64>(0.01, 3600.0), help_heading = "Jobs")]
    pub callback_seconds: f64,

    /// Attempts at a callback, counted anew by each start of the service
    #[arg(long, value_name = "N", default_value = "10", value_parser = within::<u32>(1, 1000), help_heading = "Jobs")]
    pub callback_attempts: u32,

    /// Seconds for which a failure is answered again without another attempt, doubled by each further one up to 10 minutes; 0 for
    /// never. SIGHUP forgets all
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = within::<f64>(0.0, 3600.0), help_heading = "Workers")]
    pub failure_seconds: f64,

    /// Requests that wait for a worker; further ones are refused (429)
    #[arg(long, value_name = "N", default_value = "64", value_parser = within::<usize>(0, 1 << 20), help_heading = "Workers")]
    pub queue: usize,

    /// Seconds that a request waits for a worker
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = within::<f64>(0.01, 1e6), help_heading = "Workers")]
    pub queue_seconds: f64,

    /// Workers that one client may have at a time; the queue is fair by client and price in any case [default: all of them]
    #[arg(long, value_name = "N", value_parser = within::<usize>(1, 4096), help_heading = "Workers")]
    pub client_workers: Option<usize>,

    /// Processes that draw, each with --threads threads (1 unless given) [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = within::<usize>(1, 4096), help_heading = "Workers")]
    pub workers: Option<usize>,

    /// Further processes, for cheap requests (up to 32 units) while dear ones of other clients are under way [default: as many as
    /// --workers]
    #[arg(long, value_name = "N", value_parser = within::<usize>(0, 4096), help_heading = "Workers")]
    pub spare_workers: Option<usize>,

    /// Memory of a worker's data; suffixes as of --limit
    #[arg(long, value_name = "BYTES", default_value = "1Gi", value_parser = bytes, help_heading = "Workers")]
    pub memory: u64,

    /// Seconds of processor time, of all threads, after which the work on one model is stopped (of the wall where the system does not
    /// tell, on others than Linux)
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = within::<f64>(0.01, 1e6), help_heading = "Workers")]
    pub deadline: f64,

    /// Seconds of the wall after which it is stopped, whatever it waits for [default: ten times --deadline]
    #[arg(long, value_name = "SECONDS", value_parser = within::<f64>(0.01, 1e7), help_heading = "Workers")]
    pub wall_deadline: Option<f64>,

    /// Models that one worker draws before another takes its place
    #[arg(long, value_name = "N", default_value = "500", value_parser = within::<u32>(1, u32::MAX), help_heading = "Workers")]
    pub models_of_worker: u32,

    /// Leave workers the rights that they do not need (Linux takes them otherwise)
    #[arg(long, help_heading = "Workers")]
    pub no_sandbox: bool,

    /// Log on standard error: off, error (of the service), info (and a line for each request), debug (and one for the
    /// work of each)
    #[arg(long, value_name = "LEVEL", default_value = "info",
          value_parser = ["off", "error", "info", "debug"], help_heading = "Report")]
    pub log: String,

    /// Lines of the log
    #[arg(long, value_name = "FORMAT", default_value = "json", value_parser = ["json", "text"], help_heading = "Report")]
    pub log_format: String,

    #[command(flatten)]
    pub converters: ConverterArgs,
    #[command(flatten)]
    pub encoding: EncodingArgs,
    #[command(flatten)]
    pub draw: DrawArgs,
}

impl ServeArgs {
    /// Processes that draw.
    #[must_use]
    pub fn workers(&self) -> usize {
        let processors = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        self.workers.unwrap_or_else(processors)
    }

    /// Processes that draw cheap pictures beside dear ones.
    #[must_use]
    pub fn spare_workers(&self) -> usize {
        self.spare_workers.unwrap_or_else(|| self.workers())
    }
}

/// Makes room for `--cache`, the pictures of a service: the option of that name that all pictures have is a folder of environments,
/// and workers reach none.
fn of_one_process(option: Arg) -> Arg {
    let refused = |_: &str| Err::<PathBuf, _>("workers reach no folder, and keep environments in memory");
    option.long("environment-cache").value_parser(refused).hide(true)
}

/// Checks that a text can be the value of a header.
fn header(text: &str) -> Result<String, String> {
    match axum::http::HeaderValue::from_str(text) {
        Ok(_) => Ok(text.to_owned()),
        Err(_) => Err("cannot stand in a header".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::ServeArgs;
    use clap::{Args, Command, FromArgMatches};

    /// Debug builds of clap look for options of one name.
    #[test]
    fn options_have_names_of_their_own() {
        let command = ServeArgs::augment_args(Command::new("serve"));
        command.clone().debug_assert();
        let given = command.clone().get_matches_from(["serve", "--cache", "s3://bucket/x"]);
        assert_eq!(ServeArgs::from_arg_matches(&given).unwrap().cache.as_deref(), Some("s3://bucket/x"));
        let refused = command.try_get_matches_from(["serve", "--environment-cache", "x"]).unwrap_err();
        assert!(refused.to_string().contains("workers reach no folder"), "{refused}");
    }
}
